#include "fields/quadtree_pool.h"
