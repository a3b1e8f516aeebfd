#include "bridge/image.h"
