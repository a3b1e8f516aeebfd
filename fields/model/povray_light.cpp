#include "fields/model/povray_light.h"

#include <algorithm>
#include <cmath>

#include "fields/model/mesh2_object.h"

namespace haarfield {
namespace {

/// Parses the items of a light_source.
class LightParser {
public:
    explicit LightParser(PovrayText text) : text_(text) {}

    std::optional<ModelLight> light() {
        text_.expect('{');
        position_ = text_.vector();
        text_.take(',');
        while (!text_.failed() && !text_.take('}')) take_item();
        if (text_.failed() || !is_read_) return std::nullopt;
        if (has_reach_) {
            light_.falloff = static_cast<float>(falloff_);
            // the edge is sharp if radius exceeds falloff
            light_.radius = static_cast<float>(std::min(radius_, falloff_));
        }
        light_.position = Vec3f(transform_.point(position_));
        // Suns of POV-Ray's sunpos.inc are 1e9 units away; only their direction matters.
        const bool only_shines =
            light_.kind == ModelLight::Kind::point && light_.fade_distance == 0 && !light_.area;
        if (const auto distance = double(light_.position.length());
            only_shines && distance > double(farthest))
            light_.position *= static_cast<float>(0.999 * double(farthest) / distance);
        light_.target = Vec3f(transform_.point(target_));
        if (light_.area) {
            light_.area->across = Vec3f(transform_.direction(Vec3d(light_.area->across)));
            light_.area->along = Vec3f(transform_.direction(Vec3d(light_.area->along)));
        }
        return is_good() ? std::optional(light_) : std::nullopt;
    }

private:
    void take_item() {
        const std::string_view word = text_.word();
        if (word == "color" || word == "colour") return;
        if (word == "rgb" || word == "White") return take_colour(word);
        if (word == "spotlight") return take_kind(ModelLight::Kind::spot, 30 * degree, 45 * degree);
        if (word == "cylinder") return take_kind(ModelLight::Kind::cylinder, 0.75, 1);
        if (word == "parallel") return take_kind(ModelLight::Kind::parallel, radius_, falloff_);
        if (word == "point_at") {
            target_ = text_.vector();
        } else if (word == "radius") {
            radius_ = edge();
        } else if (word == "falloff") {
            falloff_ = edge();
        } else if (word == "tightness") {
            light_.tightness = static_cast<float>(text_.number());
        } else if (word == "fade_distance") {
            light_.fade_distance = static_cast<float>(text_.number());
        } else if (word == "fade_power") {
            light_.fade_power = static_cast<float>(text_.number());
        } else if (word == "area_light") {
            take_area();
        } else if (word == "circular" || word == "orient" || word == "area_illumination") {
            take_flag_of_area(word);
        } else if (word == "shadowless") {
            light_.shadowless = true;
        } else if (word == "adaptive") {
            text_.number();
        } else if (word == "jitter") {
            return;
        } else if (word == "media_interaction" || word == "media_attenuation") {
            is_on();
        } else if (word == "photons" || word == "looks_like") {
            text_.skip_braces();
        } else if (!take_transformation(word, text_, transform_)) {
            text_.fail("plain data of a light_source");
        }
    }

    void take_colour(std::string_view word) {
        const Vec3d colour = word == "White" ? Vec3d(1, 1, 1) : text_.vector();
        light_.colour = Rgb(Vec3f(colour));
        is_read_ = true;
    }

    void take_kind(ModelLight::Kind kind, double radius, double falloff) {
        light_.kind = kind;
        radius_ = radius;
        falloff_ = falloff;
        has_reach_ = kind != ModelLight::Kind::parallel;
    }

    double edge() {
        const double number = text_.number();
        return light_.kind == ModelLight::Kind::spot ? number * degree : number;
    }

    void take_area() {
        ModelLight::Area area;
        area.across = Vec3f(text_.vector());
        text_.take(',');
        area.along = Vec3f(text_.vector());
        text_.take(',');
        area.columns = text_.count();
        text_.take(',');
        area.rows = text_.count();
        light_.area = area;
    }

    void take_flag_of_area(std::string_view word) {
        if (!light_.area) return text_.fail("area_light before it");
        const bool on = word != "area_illumination" || is_on();
        (word == "circular" ? light_.area->circular
         : word == "orient" ? light_.area->orient
                            : light_.area->illumination) = on;
    }

    /// Reads `on` or `off`; the default is on.
    bool is_on() {
        PovrayText after = text_;
        const std::string_view word = after.word();
        if (word != "on" && word != "off") return true;
        text_ = after;
        return word == "on";
    }

    bool is_good() const {
        const auto in = [](double value, double lowest, double highest) {  // false for NaN
            return value >= lowest && value <= highest;
        };
        const auto near = [&](const Vec3f& v) { return is_finite(v) && v.length() <= farthest; };
        bool good = near(light_.position) && near(light_.target);
        for (int c = 0; c < 3; ++c) good &= in(double(light_.colour[c]), 0, 1e9);
        if (light_.kind != ModelLight::Kind::point)
            good &= (light_.target - light_.position).length() > 1e-6f;
        if (has_reach_)
            good &= in(double(light_.radius), 0, 1e6) && light_.falloff > 0 &&
                    in(double(light_.falloff), double(light_.radius), 1e6);
        if (light_.kind == ModelLight::Kind::spot) good &= double(light_.falloff) <= pi;
        good &= in(double(light_.tightness), 0, 100) && in(double(light_.fade_power), 0, 100) &&
                in(double(light_.fade_distance), 0, 1e6);
        if (light_.area) {
            good &= in(light_.area->columns, 1, 1024) && in(light_.area->rows, 1, 1024);
            good &= near(light_.area->across) && near(light_.area->along);
            good &= light_.kind == ModelLight::Kind::point || light_.kind == ModelLight::Kind::spot;
        }
        return good;
    }

    static constexpr double degree = pi / 180;
    static constexpr float farthest = 1e6f;  // Distance of a position from the origin.

    PovrayText text_;
    ModelLight light_;
    AffineMap transform_;
    Vec3d position_{0, 0, 0}, target_{0, 0, 1};  // POV-Ray's defaults
    double radius_ = 0, falloff_ = 0;
    bool is_read_ = false, has_reach_ = false;
};

}  // namespace

std::optional<ModelLight> povray_light(PovrayText text) {
    return LightParser(text).light();
}

}  // namespace haarfield
