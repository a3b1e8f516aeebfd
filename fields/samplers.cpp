#include "fields/samplers.h"
