#include "fields/visibility_field.h"
