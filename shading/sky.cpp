#include "shading/sky.h"
