#include "fields/mesh_preparation.h"
