#include "scenes/scene_reader.h"
