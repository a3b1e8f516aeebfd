#include "bridge/light_dome.h"
#include "scenes/scene_entities.h"
#include "scenes/scene_reader.h"

#include <cstdio>

int main(int, char** arguments) {
    const auto scene = haarfield::read_scene(arguments[1]);
    if (!scene) return std::puts(scene.error().message().c_str()), 1;
    const auto entities =
        haarfield::prepare_scene_entities(*scene, {.fields_folder = "fields", .fields = false});
    if (!entities) return std::puts(entities.error().message().c_str()), 1;
    const auto lights = haarfield::light_dome(haarfield::sky_image({}, 64), {.lights = 16});
    std::printf("%zu instances, %zu lights\n", scene->instances.size(), lights.size());
    return lights.empty() ? 1 : 0;
}
