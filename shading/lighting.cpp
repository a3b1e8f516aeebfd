#include "shading/lighting.h"
