#include "shading/environment.h"
