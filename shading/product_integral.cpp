#include "shading/product_integral.h"
