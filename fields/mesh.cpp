#include "fields/mesh.h"
