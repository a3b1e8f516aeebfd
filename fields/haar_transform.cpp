#include "fields/haar_transform.h"
