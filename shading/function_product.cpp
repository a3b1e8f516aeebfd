#include "shading/function_product.h"
