#include "fields/vdb_store.h"
