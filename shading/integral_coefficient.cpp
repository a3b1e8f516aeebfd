#include "shading/integral_coefficient.h"
