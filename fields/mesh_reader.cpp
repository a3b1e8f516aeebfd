#include "fields/mesh_reader.h"
