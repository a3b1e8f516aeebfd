#include "scenes/lamp_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace haarfield {
namespace {

constexpr Range lamp_colours{0, 1e9};
constexpr Range powers{0, 100};
constexpr float least_distance = 1e-6f;  // [m]

const std::map<std::string, LampKind, std::less<>> kinds{{"point", LampKind::point},
                                                         {"spot", LampKind::spot},
                                                         {"cylinder", LampKind::cylinder},
                                                         {"parallel", LampKind::parallel}};

void refuse_beside(TomlTable& table, LampKind kind, std::initializer_list<const char*> keys,
                   const char* kinds_that_have_it) {
    const auto named = std::ranges::find_if(kinds, [&](const auto& entry) { return entry.second == kind; });
    for (const char* key : keys)
        if (table.has(key))
            table.refuse(key, fmt::format("{}.{} has no effect in a lamp of kind \"{}\"; expected kind {}",
                                          table.name(), key, named->first, kinds_that_have_it));
}

// Reads radius and falloff: angles in degrees, or lengths for cylinders.
void take_edge(TomlTable& table, Lamp& lamp) {
    if (lamp.kind == LampKind::cylinder) {
        lamp.radius = 0.75f;
        lamp.falloff = 1;
        table.take("radius", lamp.radius, {0, 1e6});
        table.take("falloff", lamp.falloff, {0, 1e6, true});
    } else {
        float radius = 30, falloff = 45;
        table.take("radius", radius, {0, 180});
        table.take("falloff", falloff, {0, 180, true});
        lamp.radius = radians(radius);
        lamp.falloff = radians(falloff);
    }
    if (!(lamp.radius <= lamp.falloff))
        table.refuse(
            table.has("falloff") ? "falloff" : "radius",
            fmt::format("{}.falloff is less than the radius; expected at least the radius", table.name()));
    table.take("tightness", lamp.tightness, powers);
}

LampArea parsed_area(TomlTable table) {
    LampArea area;
    table.require("across");
    table.require("along");
    table.take("across", area.across, coordinates);
    table.take("along", area.along, coordinates);
    std::array<std::uint32_t, 2> samples{area.columns, area.rows};
    table.take("samples", samples, {1, 1024});
    area.columns = samples[0];
    area.rows = samples[1];
    table.take("circular", area.circular);
    table.take("orient", area.orient);
    table.take("illumination", area.illumination);
    table.finish();
    return area;
}

void take_name(TomlTable& table, std::span<const SceneLamp> before, SceneLamp& lamp) {
    table.take("name", lamp.name);
    const auto same = std::ranges::find(before, lamp.name, &SceneLamp::name);
    if (table.has("name") && same != before.end())
        table.refuse("name",
                     fmt::format("{}.name is \"{}\", which is the name of lights[{}]; expected a unique name",
                                 table.name(), lamp.name, same - before.begin()));
    // Numbers unnamed lamps, skipping names in use.
    for (std::size_t number = before.size() + 1; lamp.name.empty(); ++number) {
        std::string numbered = fmt::format("light_{}", number);
        if (std::ranges::find(before, numbered, &SceneLamp::name) == before.end())
            lamp.name = std::move(numbered);
    }
}

}  // namespace

std::vector<Lamp> lamps_of(std::span<const SceneLamp> lamps) {
    return {lamps.begin(), lamps.end()};
}

SceneLamp parsed_lamp(TomlTable table, std::span<const Instance> instances,
                      std::span<const SceneLamp> before) {
    SceneLamp lamp;
    take_name(table, before, lamp);
    std::string kind = "point";
    table.take("kind", kind);
    if (const auto known = kinds.find(kind); known != kinds.end())
        lamp.kind = known->second;
    else
        table.refuse(
            "kind",
            fmt::format("{}.kind is \"{}\"; expected \"point\", \"spot\", \"cylinder\" or \"parallel\"",
                        table.name(), kind));
    table.require("position");
    table.take("position", lamp.position, coordinates);
    table.take("colour", lamp.colour, lamp_colours);
    table.take("fade_distance", lamp.fade_distance, {0, 1e6, true});
    table.take("fade_power", lamp.fade_power, powers);
    table.take("shadowless", lamp.shadowless);
    if (lamp.kind == LampKind::point) {
        refuse_beside(table, lamp.kind, {"target"}, "\"spot\", \"cylinder\" or \"parallel\"");
    } else {
        table.require("target");
        table.take("target", lamp.target, coordinates);
        if (table.has("target") && !((lamp.target - lamp.position).length() > least_distance))
            table.refuse("target",
                         fmt::format("{}.target equals the position; expected another point", table.name()));
    }
    if (lamp.kind == LampKind::spot || lamp.kind == LampKind::cylinder)
        take_edge(table, lamp);
    else
        refuse_beside(table, lamp.kind, {"radius", "falloff", "tightness"}, "\"spot\" or \"cylinder\"");
    if (lamp.kind == LampKind::point || lamp.kind == LampKind::spot) {
        if (const toml::table* area = table.take_table("area"))
            lamp.area = parsed_area(TomlTable(*area, table.name() + ".area", table.file()));
    } else {
        refuse_beside(table, lamp.kind, {"area"}, "\"point\" or \"spot\"");
    }
    std::string instance_name;
    table.take("looks_like", instance_name);
    if (table.has("looks_like")) {
        const auto instance = std::ranges::find(instances, instance_name, &Instance::name);
        if (instance != instances.end())
            lamp.looks_like = static_cast<std::size_t>(instance - instances.begin());
        else
            table.refuse("looks_like", fmt::format("{}.looks_like is \"{}\"; there is no such instance",
                                                   table.name(), instance_name));
    }
    table.finish();
    return lamp;
}

LampKeyframe parsed_lamp_keyframe(TomlTable table, std::span<const SceneLamp> lamps,
                                  std::span<const LampKeyframe> before) {
    LampKeyframe keyframe;
    std::string name;
    table.require("time");
    table.take("time", keyframe.time, {0, 1e6});
    table.take("light", name);
    const auto lamp = std::ranges::find(lamps, name, &SceneLamp::name);
    if (lamp != lamps.end())
        keyframe.lamp = static_cast<std::size_t>(lamp - lamps.begin());
    else
        table.refuse("light", fmt::format("{}.light is \"{}\"; there is no such light", table.name(), name));
    const auto take = [&](const char* key, const Range& range, std::optional<Vec3f>& value) {
        Vec3f taken(0.0f);
        table.take(key, taken, range);
        if (table.has(key)) value = taken;
    };
    take("position", coordinates, keyframe.position);
    take("target", coordinates, keyframe.target);
    take("colour", lamp_colours, keyframe.colour);
    if (!keyframe.position && !keyframe.target && !keyframe.colour)
        table.refuse("", fmt::format("{} has none of position, target and colour; expected at least one",
                                     table.name()));
    for (const LampKeyframe& earlier : before)
        if (earlier.lamp == keyframe.lamp && !(keyframe.time > earlier.time))
            table.refuse(
                "time",
                fmt::format("{}.time is {}; expected more than {}, the time of the previous keyframe of {}",
                            table.name(), keyframe.time, earlier.time, name));
    table.finish();
    return keyframe;
}

}  // namespace haarfield
