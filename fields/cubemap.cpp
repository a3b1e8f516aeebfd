#include "fields/cubemap.h"
