#include "bridge/povray/reference_scene.h"

#include "bridge/povray/interpolated_normals.h"
#include "bridge/povray/reference_filters.h"
#include "bridge/povray/texture_files.h"

#include "fields/file/write_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

namespace haarfield {
namespace {

constexpr double wanted_radius = 64;      // POV-Ray units; far above its shadow tolerance of 1e-3
constexpr double largest_distance = 1e6;  // POV-Ray units; below its limit for rays of 1e7
constexpr int most_bounces = 20;          // POV-Ray's limit
constexpr float dimmest_tint = 1e-4f;     // relative to the strongest channel of a specular lobe

bool is_grey(const Rgb& colour) {
    return colour.x == colour.y && colour.y == colour.z;
}

/// Returns the factor between the pigment and the diffuse albedo.
float diffuse_share(const Material& material) {
    float share = 0;
    for (int c = 0; c < 3; ++c)
        if (material.pigment[c] > 0) share = std::max(share, material.diffuse[c] / material.pigment[c]);
    return share;
}

/// Returns the text of a pigment: a colour, or an image multiplied by it.
///
/// is_opaque  true: the image is opaque, regardless of its alpha.
std::string pigment_text(const Rgb& colour, const TextureFile* image, bool is_opaque) {
    if (!image) return fmt::format("rgb {}", povray_vector(colour));
    if (colour == Rgb(1.0f)) return is_opaque ? image->opaque : image->pigment;
    return multiplied_pigment(image->pigment, colour, is_opaque ? std::string() : image->transmission);
}

/// A POV-Ray texture, possibly of several layers.
struct PovrayTexture {
    std::string text;           ///< Empty if the surface has only specular lobes that its image tints.
    std::string tinted;         ///< Those lobes, as a second texture that is averaged with `text`.
    std::string nothing_where;  ///< A pattern that is 1 where the surface is absent; or empty.
};

std::string declaration(const std::string& name, const PovrayTexture& texture) {
    std::string text;
    if (texture.text.empty() || texture.tinted.empty())
        text =
            fmt::format("#declare {} =\n  {}\n", name, texture.text.empty() ? texture.tinted : texture.text);
    else
        text = fmt::format(
            "#declare {0}_Base =\n  {1}\n#declare {0}_Tinted =\n  {2}\n"
            "#declare {0} = texture {{ average texture_map {{ [1 {0}_Base] [1 {0}_Tinted] }} }}\n",
            name, texture.text, texture.tinted);
    if (!texture.nothing_where.empty())
        text += fmt::format(
            "#declare {0} = texture {{ {1} texture_map {{\n  [0 {0}]\n"
            "  [1 pigment {{ rgbt 1 }} finish {{ ambient 0 emission 0 diffuse 0 }}] }} }}\n",
            name, texture.nothing_where);
    return text;
}

/// Specular lobes in the terms of POV-Ray's `finish`.
struct PovraySpecular {
    float phong = 0, blinn = 0;
    Rgb tint{1, 1, 1};  ///< Multiplies the light's colour; 1 in its strongest channel.

    PovraySpecular(const Material& material, const Rgb& colour) {
        const float strongest = std::max({colour.x, colour.y, colour.z});
        const bool is_physical = material.convention == LobeConvention::physical;
        phong = strongest * (is_physical ? 0.5f * (material.shininess + 2) : material.phong);
        blinn = is_physical ? 0 : strongest * material.blinn;
        if (!is_grey(colour)) tint = colour / strongest;
    }

    bool are_there() const { return phong > 0 || blinn > 0; }

    /// share  factor of the lobes.
    std::string text(const Material& material, float share) const {
        std::string finish;
        if (phong > 0) finish += fmt::format(" phong {} phong_size {}", share * phong, material.shininess);
        if (blinn > 0) finish += fmt::format(" specular {} roughness {}", share * blinn, material.roughness);
        return finish;
    }
};

/// Returns a layer that emits and reflects nothing and filters the light of the layers below.
std::string filter_layer(const std::string& pigment) {
    return fmt::format("\n  texture {{ pigment {{ {} }} finish {{ ambient 0 emission 0 diffuse 0 }} }}",
                       pigment);
}

/// Returns specular lobes without a diffuse term, under a layer of their colour times the image's.
std::string tinted_texture(const Material& material, const PovraySpecular& highlights, float share,
                           const TextureFile& image) {
    return fmt::format("texture {{ pigment {{ rgb 1 }} finish {{ ambient 0 emission 0 diffuse 0{} }} }}",
                       highlights.text(material, share)) +
           filter_layer(filter_pigment(image.pigment, highlights.tint));
}

/// Returns everything but the specular lobes that an image tints.
///
/// share     factor of emission, diffuse term and specular lobes.
/// is_mixed  true: the image is opaque, regardless of its alpha.
std::string base_texture(const Surface& surface, const Rgb& colour, const PovraySpecular& highlights,
                         float share, const TextureFile* image, bool is_mixed) {
    const Material& material = surface.material;
    const float metallic = material.convention == LobeConvention::physical ? 0 : material.metallic;
    Rgb pigment = metallic > 0 ? material.pigment : material.diffuse;
    float diffuse = metallic > 0 ? diffuse_share(material) : 1;
    const Rgb own = surface.own_radiance();
    if (own != Rgb(0.0f) && pigment == Rgb(0.0f)) {
        pigment = Rgb(1.0f);
        diffuse = 0;
    }
    // With a grey factor, the image's own pigment is used.
    if (image && metallic == 0 && is_grey(pigment)) {
        diffuse *= pigment.x;
        pigment = Rgb(1.0f);
    }
    const float dimmest = dimmest_tint * std::max({pigment.x, pigment.y, pigment.z});
    Rgb emission(0.0f);
    if (own != Rgb(0.0f))
        for (int c = 0; c < 3; ++c) {
            pigment[c] = std::max(pigment[c], dimmest);
            emission[c] = share * own[c] / pigment[c];
        }
    pigment *= colour;
    Rgb tint = highlights.tint;
    for (int c = 0; c < 3; ++c) {
        tint[c] = std::max(tint[c], dimmest_tint);
        pigment[c] /= tint[c];
    }
    std::string text = fmt::format("texture {{ pigment {{ {} }} finish {{ ambient 0 emission {} diffuse {}{}",
                                   pigment_text(pigment, image, is_mixed),
                                   own != Rgb(0.0f) ? "rgb Emission_Share*" + povray_vector(emission) : "0",
                                   share * diffuse, highlights.text(material, share));
    if (metallic > 0) text += fmt::format(" metallic {}", metallic);
    text += povray_reflection(surface.reflection, share) + " } }";
    if (tint != Rgb(1.0f)) text += filter_layer(fmt::format("rgbf <{}, {}, {}, 1>", tint.x, tint.y, tint.z));
    return text;
}

/// Returns a surface as a POV-Ray texture.
///
/// POV-Ray's specular lobe has the colour of the light, or of the pigment if it is metallic. To give it
/// another colour, it lies under a layer that reflects nothing itself and filters by the tint. The diffuse
/// colour below that layer is divided by the tint. A channel without specular light keeps 1e-4 of the
/// strongest channel, so that the division is defined. Specular lobes that an image tints are a separate
/// texture below a layer of the image. The surface is the mean of that texture and of the remaining one, each
/// twice as bright.
///
/// Such a lobe would also be visible where an image is transparent, as on glass. With alpha, the surface is
/// therefore a mixture of an opaque one and of nothing.
///
/// colour  of the vertex.
/// image   of the surface's texture; null if it has none.
PovrayTexture surface_texture(const Surface& surface, const Rgb& colour, const TextureFile* image) {
    const Material& material = surface.material;
    // `metallic` tints by the pigment, which is the image.
    const float tinted = material.metallic > 0 ? 0 : surface.tinted_specular;
    const PovraySpecular of_image(material, image ? material.specular * colour * tinted : Rgb(0.0f));
    const Rgb untinted = Rgb(1 - tinted);
    const PovraySpecular own(material, material.specular * (image ? untinted : untinted + colour * tinted));
    PovrayTexture texture;
    if (image && (own.are_there() || of_image.are_there())) texture.nothing_where = image->transmission;
    const bool is_mixed = !texture.nothing_where.empty();
    const bool has_base =
        material.diffuse != Rgb(0.0f) || surface.own_radiance() != Rgb(0.0f) || own.are_there();
    const float share = has_base && of_image.are_there() ? 2 : 1;
    if (of_image.are_there()) texture.tinted = tinted_texture(material, of_image, share, *image);
    if (has_base || texture.tinted.empty())
        texture.text = base_texture(surface, colour, own, share, image, is_mixed);
    return texture;
}

/// True if POV-Ray can render a metallic material: its pigment determines the colour of both terms.
bool has_metals_colours(const Material& material) {
    if (!is_grey(material.specular)) return false;
    const Rgb diffuse = material.pigment * diffuse_share(material);
    for (int c = 0; c < 3; ++c)
        if (!(std::abs(diffuse[c] - material.diffuse[c]) <= 1e-5f)) return false;
    return true;
}

Result<Done> check_materials(const ReferenceInstance& instance, const std::string& where) {
    for (std::size_t k = 0; k < instance.materials.size(); ++k) {
        const Material& material = instance.materials[k];
        const auto refused = [&](const char* what, float value, const char* wanted) {
            return Error{where, fmt::format("material {} has {} {}; expected {}", k, what, value, wanted)};
        };
        const auto in = [](float value, double lowest, double highest) {  // false for NaN too
            return value >= lowest && value <= highest;
        };
        for (int c = 0; c < 3; ++c) {
            if (!in(material.diffuse[c], 0, largest_distance))
                return refused("diffuse", material.diffuse[c], "0 or more");
            if (!in(material.specular[c], 0, largest_distance))
                return refused("specular", material.specular[c], "0 or more");
            if (!in(material.pigment[c], 0, 1)) return refused("pigment", material.pigment[c], "[0, 1]");
        }
        if (!in(material.shininess, 1e-6, 1e6)) return refused("shininess", material.shininess, "above 0");
        if (!in(material.phong, 0, 1e6)) return refused("phong", material.phong, "0 or more");
        if (!in(material.blinn, 0, 1e6)) return refused("blinn", material.blinn, "0 or more");
        if (!in(material.roughness, 1e-6, 1e6)) return refused("roughness", material.roughness, "above 0");
        if (!in(material.metallic, 0, 1)) return refused("metallic", material.metallic, "[0, 1]");
        if (material.metallic > 0 && !has_metals_colours(material))
            return Error{
                where,
                fmt::format("material {} is metallic; expected a white specular colour and a diffuse colour "
                            "that is a multiple of the pigment",
                            k)};
    }
    for (std::uint16_t index : instance.mesh->vertex_materials)
        if (index >= instance.materials.size())
            return Error{where, fmt::format("the mesh has the material index {}; expected less than {}",
                                            index, instance.materials.size())};
    return Done{};
}

Result<Done> check_instances(std::span<const ReferenceInstance> instances) {
    std::set<std::string_view> names;
    for (const ReferenceInstance& instance : instances) {
        assert(instance.mesh);
        const std::string where = "instance " + instance.name;
        HF_TRY_DONE(check_povray_mesh(*instance.mesh, where));
        if (instance.mesh->normals.size() != instance.mesh->positions.size() ||
            instance.mesh->vertex_materials.size() != instance.mesh->positions.size())
            return Error{where, "some vertices lack normals or materials"};
        for (std::size_t i = 0; i < instance.mesh->normals.size(); ++i)
            if (!is_finite(instance.mesh->normals[i]))
                return Error{where, fmt::format("the normal of vertex {} is not finite", i)};
        HF_TRY_DONE(check_materials(instance, where));
        HF_TRY_DONE(check_placement(where, instance.placement));
        if (!instance.surfaces.empty() && instance.surfaces.size() != instance.materials.size())
            return Error{where, "the numbers of surfaces and materials differ"};
        if (has_textures(instance.surfaces) && instance.mesh->uvs.size() != instance.mesh->positions.size())
            return Error{where, "has a texture but no texture coordinates"};
        if (!names.insert(instance.name).second)
            return Error{where, "two instances have this name; expected unique names"};
    }
    return Done{};
}

/// The textures of a mesh, and the texture index of each vertex.
class MeshTextures {
public:
    MeshTextures(const ReferenceInstance& instance, const TextureFiles& files) {
        const Mesh& mesh = *instance.mesh;
        std::map<std::pair<std::uint16_t, std::array<float, 3>>, std::size_t> known;
        for (std::uint16_t m = 0; m < instance.materials.size(); ++m) {
            known.emplace(std::pair(m, std::array{1.0f, 1.0f, 1.0f}), textures.size());
            textures.push_back(texture_of(instance, m, Rgb(1.0f), files));
        }
        of_vertex.assign(mesh.vertex_materials.begin(), mesh.vertex_materials.end());
        for (std::size_t v = 0; v < of_vertex.size(); ++v) {
            const std::uint16_t m = mesh.vertex_materials[v];
            if (!is_coloured(instance, m)) continue;
            const Rgb& colour = mesh.colours[v];
            const auto [entry, is_new] =
                known.emplace(std::pair(m, std::array{colour.x, colour.y, colour.z}), textures.size());
            if (is_new) textures.push_back(texture_of(instance, m, colour, files));
            of_vertex[v] = entry->second;
        }
    }

    static bool is_coloured(const ReferenceInstance& instance, std::uint16_t material) {
        return !instance.surfaces.empty() && instance.surfaces[material].coloured;
    }

    std::vector<PovrayTexture> textures;
    std::vector<std::size_t> of_vertex;

private:
    static PovrayTexture texture_of(const ReferenceInstance& instance, std::uint16_t material,
                                    const Rgb& colour, const TextureFiles& files) {
        Surface plain;
        plain.material = instance.materials[material];
        const Surface& surface = instance.surfaces.empty() ? plain : instance.surfaces[material];
        return surface_texture(surface, colour, surface.texture ? &files.at(surface.texture.get()) : nullptr);
    }
};

std::string mesh_text(const ReferenceInstance& instance, const std::string& object,
                      const TextureFiles& files) {
    const Mesh& mesh = *instance.mesh;
    const double magnified = small_triangle_scale(mesh);
    std::string text;
    auto out = std::back_inserter(text);
    fmt::format_to(out,
                   "// For the ray tracer: {0} vertices, {1} triangles; metres.\n"
                   "#ifndef ({2}_Included)\n#declare {2}_Included = 1;\n"
                   "#declare {2}_Version = version;\n#version 3.7;\n\n",
                   mesh.positions.size(), mesh.triangles.size(), object);
    const MeshTextures textures(instance, files);
    for (std::size_t k = 0; k < textures.textures.size(); ++k)
        text += declaration(fmt::format("{}_Material_{}", object, k), textures.textures[k]);
    fmt::format_to(out, "#declare {} = mesh2 {{\n", object);
    append_povray_vectors(text, "vertex_vectors", mesh.positions, static_cast<float>(magnified));
    const InterpolatedNormals normals = interpolated_normals(mesh);
    append_povray_vectors(text, "normal_vectors", normals.normals);
    const bool has_images = has_textures(instance.surfaces);
    if (has_images) append_povray_uvs(text, mesh.uvs);
    fmt::format_to(out, "texture_list {{ {}", textures.textures.size());
    for (std::size_t k = 0; k < textures.textures.size(); ++k)
        fmt::format_to(out, ", texture {{ {}_Material_{} }}", object, k);
    fmt::format_to(out, " }}\nface_indices {{ {}", mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {  // all corners of a triangle have the same material
        fmt::format_to(out, ",\n<{},{},{}>,{}", a, b, c, textures.of_vertex[a]);
        if (MeshTextures::is_coloured(instance, mesh.vertex_materials[a]))
            fmt::format_to(out, ",{},{}", textures.of_vertex[b], textures.of_vertex[c]);
    }
    text += " }\n";
    if (!normals.indices.empty()) append_povray_indices(text, "normal_indices", normals.indices);
    fmt::format_to(out, "{}{}scale {:.17g}\n}}\n\n#version {}_Version;\n#end\n",
                   has_images ? "uv_mapping\n" : "", povray_interior(instance.surfaces), 1 / magnified,
                   object);
    return text;
}

/// Returns the power of two that magnifies the median object to wanted_radius or up to twice that, unless
/// POV-Ray's limit for rays requires less.
double chosen_world_scale(std::span<const ReferenceInstance> instances, const Camera& camera,
                          std::span<const Lamp> lamps, double& extent) {
    std::vector<double> radii;
    extent = Vec3d(camera.position).length();
    for (const Lamp& lamp : lamps) extent = std::max(extent, Vec3d(lamp.position).length());
    for (const ReferenceInstance& instance : instances) {
        const Bounds bounds = mesh_bounds(*instance.mesh);
        const double radius = double(instance.placement.scale) * bounds.radius();
        const Vec3d centre = instance.placement.point_to_world(Vec3d(bounds.centre()));
        radii.push_back(radius);
        extent = std::max(extent, centre.length() + radius);
    }
    if (radii.empty()) return 1;
    std::nth_element(radii.begin(), radii.begin() + radii.size() / 2, radii.end());
    const double median = radii[radii.size() / 2];
    double exponent = median > 0 ? std::ceil(std::log2(wanted_radius / median)) : 0;
    if (extent > 0) exponent = std::min(exponent, std::floor(std::log2(largest_distance / extent)));
    return std::exp2(std::clamp(exponent, -40.0, 40.0));
}

void add_warnings(std::vector<std::string>& warnings, std::span<const ReferenceInstance> instances) {
    std::set<std::string> said;
    for (const ReferenceInstance& instance : instances)
        for (const Material& material : instance.materials)
            if (material.convention == LobeConvention::physical && luminance(material.specular) > 0)
                said.insert(fmt::format(
                    "POV-Ray's specular lobes lack the cosine: the physical lobe of shininess {} is written "
                    "as phong {} and is too bright at grazing angles",
                    material.shininess, luminance(material.specular) * 0.5f * (material.shininess + 2)));
    warnings.assign(said.begin(), said.end());
}

std::string bounces_text(const ReferenceBounces& bounces) {
    const int limit = bounces.baked.empty() ? bounces.limit : 1;
    if (limit == 0) return "";
    // Without its own adc_bailout, radiosity ends after six bounces.
    return fmt::format(
        "// Indirect light of the light sources.\n"
        "#ifndef ({})\n"
        "#declare Recursion_Limit = {};\n"
        "#ifdef ({}) #declare Recursion_Limit = {}; #end\n"
        "#ifdef ({}) #declare Recursion_Limit = 1; #end\n"
        "global_settings {{ radiosity {{ recursion_limit Recursion_Limit brightness 1 gray_threshold 0\n"
        "  normal on pretrace_start 0.08 pretrace_end 0.01 count 400 error_bound 0.2 nearest_count 10\n"
        "  minimum_reuse 0.004 adc_bailout 1e-6 }} }}\n"
        "#end\n",
        without_bounces, limit, emitters_by_radiosity, std::min(limit + 1, most_bounces), direct_light_only);
}

/// Light sources in POV-Ray's language.
struct LightSet {
    std::string text;
    int count = 0;

    void add(const std::string& light) {
        text += light;
        ++count;
    }
};

/// Returns a light that is outside of everything. `Share` scales it. [POV-Ray units]
std::string dome_light(const DirectionalLight& light, double distance) {
    const Vec3d place = Vec3d(light.direction) * distance;
    const Rgb colour = light.irradiance * static_cast<float>(1 / pi);
    return fmt::format(
        "light_source {{ <{:.9g},{:.9g},{:.9g}> rgb Share*<{:.7g},{:.7g},{:.7g}> parallel point_at 0 }}\n",
        place.x, place.y, place.z, colour.x, colour.y, colour.z);
}

/// Returns the baked objects, which are visible to radiosity only.
std::string baked_text(const ReferenceBounces& bounces, double world_scale) {
    std::string text;
    for (const ReferenceBounces::BakedObject& baked : bounces.baked)
        text +=
            fmt::format("#include \"{}\"\nobject {{ {} no_image no_shadow no_reflection scale {:.17g} }}\n",
                        baked.include.filename().string(), baked.name, world_scale);
    return text;
}

std::vector<Emitter> world_emitters(std::span<const ReferenceInstance> instances) {
    std::vector<Emitter> emitters;
    for (const ReferenceInstance& instance : instances)
        for (Emitter emitter : instance.emitters) {
            for (Vec3f& corner : emitter.corners) corner = instance.placement.point_to_world(corner);
            emitters.push_back(emitter);
        }
    return emitters;
}

/// Returns the objects with the albedo of their diffuse term at the vertices.
WorldSurface world_surface(std::span<const ReferenceInstance> instances) {
    WorldSurface world;
    for (const ReferenceInstance& instance : instances) {
        std::vector<Rgb> albedo = vertex_tints(*instance.mesh, instance.surfaces);
        albedo.resize(instance.mesh->positions.size(), Rgb(1.0f));
        for (std::size_t v = 0; v < albedo.size(); ++v)
            albedo[v] *= instance.materials[instance.mesh->vertex_materials[v]].diffuse;
        world.add(*instance.mesh, instance.placement, albedo);
    }
    return world;
}

/// Hides an object from radiosity if its light is represented otherwise: by a baked object, or by the lamps
/// of its emitters. The runs that gather bounces have no such lamps or no emission.
std::string radiosity_text(const ReferenceInstance& instance, const ReferenceBounces& bounces) {
    if (!bounces.baked.empty()) return " no_radiosity";
    if (bounces.limit == 0 || instance.emitters.empty()) return "";
    return fmt::format(" #ifndef ({}) #ifndef ({}) no_radiosity #end #end", reduced_lights_alone,
                       emitters_by_radiosity);
}

bool is_shape_of_a_lamp(std::span<const Lamp> lamps, std::size_t instance) {
    return std::ranges::any_of(lamps, [&](const Lamp& lamp) { return lamp.looks_like == instance; });
}

void add_warnings_of_shapes(std::vector<std::string>& warnings, std::span<const ReferenceInstance> instances,
                            const Environment& environment, std::span<const Lamp> lamps) {
    const bool is_dark =
        environment.suns.empty() &&
        std::ranges::all_of(environment.image.pixels, [](const Rgb& pixel) { return pixel == Rgb(0.0f); });
    for (std::size_t i = 0; i < instances.size(); ++i) {
        if (!is_shape_of_a_lamp(lamps, i)) continue;
        const bool is_only = std::ranges::all_of(
            lamps, [&](const Lamp& lamp) { return lamp.looks_like == i || lamp.shadowless; });
        if (!is_dark || !is_only)
            warnings.push_back(
                fmt::format("{} is the visible shape of a lamp: in POV-Ray it casts no shadow from any other "
                            "light either",
                            instances[i].name));
    }
}

}  // namespace

Result<ReferenceFiles> write_reference_scene(const std::filesystem::path& folder,
                                             const std::string& scene_name, const Camera& camera,
                                             std::span<const ReferenceInstance> instances,
                                             const Environment& environment, int lights,
                                             const ReferenceBounces& bounces, std::span<const Lamp> lamps,
                                             std::span<const SceneFilter> filters, double assumed_gamma) {
    assert(lights >= 16 && bounces.limit >= 0 && bounces.limit <= most_bounces);
    if (!is_scene_name(scene_name))
        return Error{scene_name, "is not a valid scene name; expected letters, digits, _, - and ."};
    HF_TRY_DONE(check_instances(instances));

    ReferenceFiles files;
    double extent = 0;
    files.world_scale = chosen_world_scale(instances, camera, lamps, extent);
    HF_TRY(const std::string camera_text, povray_camera(camera, files.world_scale));
    HF_TRY_DONE(make_folder(folder));
    const LatLongImage background = image_with_suns(environment);
    const bool has_mirrors = std::ranges::any_of(
        instances, [](const ReferenceInstance& instance) { return any_reflects(instance.surfaces); });
    HF_TRY(const std::string background_text,
           write_background(folder, scene_name, {&background, has_mirrors, assumed_gamma}));
    add_warnings(files.warnings, instances);
    add_warnings_of_shapes(files.warnings, instances, environment, lamps);
    HF_TRY(const TextureFiles textures, write_textures(folder, scene_name, textures_of(instances)));
    files.images = files_of(textures);

    std::string text = fmt::format(
        "// {0}: the reference for haarfield's baked scene, lit by a dome of parallel lights.\n"
        "// povray +I{0}.pov +W{1} +H{2} +A0.0 +AM1 +R3 -J\n"
        "// One metre is {3} units, because POV-Ray's shadows ignore occluders nearer than 1e-3 units.\n"
        "#version 3.7;\n"
        "global_settings {{ assumed_gamma {9:.6g} adc_bailout 0 max_trace_level 100 }}\n"
        "#ifdef ({7})\n"
        "// The background's light alone: one bounce at POV-Ray's highest quality.\n"
        "global_settings {{ radiosity {{ recursion_limit 1 brightness 1 gray_threshold 0 normal on\n"
        "  pretrace_start 0.08 pretrace_end 0.01 count 1600 error_bound 0.1 nearest_count 10\n"
        "  minimum_reuse 0.004 }} }}\n"
        "#end\n{8}\n{4}\n{5}\n"
        "#ifndef ({6})\n",
        scene_name, camera.width, camera.height, files.world_scale, camera_text, background_text,
        background_only, by_radiosity, bounces_text(bounces), assumed_gamma);
    text += "#declare Emission_Share = 1;\n";
    // Bounces are gathered under lamps instead of emission.
    const bool has_emitters =
        std::ranges::any_of(instances, [](const auto& instance) { return !instance.emitters.empty(); });
    if (has_emitters && bounces.limit > 0)
        text += fmt::format("#ifdef ({}) #declare Emission_Share = 0; #end\n", reduced_lights_alone);
    std::vector<std::string> declarations;
    for (const auto& [texture, file] : textures) declarations.push_back(file.text);
    std::ranges::sort(declarations);
    for (const std::string& declaration : declarations) text += declaration;

    using Shared = std::pair<const Mesh*, const Material*>;
    std::map<Shared, std::size_t> mesh_number;
    std::string objects;
    for (std::size_t i = 0; i < instances.size(); ++i) {
        const ReferenceInstance& instance = instances[i];
        const auto [entry, is_new] =
            mesh_number.emplace(Shared{instance.mesh, instance.materials.data()}, mesh_number.size());
        const std::string object = fmt::format("{}_Mesh_{}", povray_identifier(scene_name), entry->second);
        if (is_new) {
            files.includes.push_back(folder / fmt::format("{}_mesh_{}.inc", scene_name, entry->second));
            HF_TRY_DONE(write_file(files.includes.back(), mesh_text(instance, object, textures)));
            text += fmt::format("#include \"{}\"\n", files.includes.back().filename().string());
        }
        const Vec3d translate = Vec3d(instance.placement.translate) * files.world_scale;
        const Rotation& rotate = instance.placement.rotate;
        const std::string turned = is_identity(rotate) ? "" : " " + povray_rotation(rotate);
        objects +=
            fmt::format("object {{ {}{} scale {:.17g} translate <{:.12g}, {:.12g}, {:.12g}>{}{} }}  // {}\n",
                        object, turned, instance.placement.scale * files.world_scale, translate.x,
                        translate.y, translate.z, radiosity_text(instance, bounces),
                        is_shape_of_a_lamp(lamps, i) ? " no_shadow" : "", povray_identifier(instance.name));
    }
    HF_TRY(const std::string filter_statements,
           write_reference_filters(folder, scene_name, filters, files.world_scale, files.includes));
    text += "\n" + objects + filter_statements + baked_text(bounces, files.world_scale) + "\n";
    // Baked objects emit their light for any selection of lights.
    files.has_bounces = bounces.limit > 0 && bounces.baked.empty();

    const double distance = std::max(1e4, 8 * extent * files.world_scale);  // outside of everything
    text += fmt::format(
        "// Two sets of lights. Each represents the whole environment; alone, it is twice as bright.\n"
        "#declare Share = 0.5;\n#ifdef ({0}) #declare Share = 1; #end\n#ifdef ({1}) #declare Share = 1; "
        "#end\n",
        first_dome_only, second_dome_only);
    // With baked objects, radiosity uses the emission itself.
    const std::vector<Emitter> emitters =
        bounces.baked.empty() ? world_emitters(instances) : std::vector<Emitter>();
    files.has_emitters = !emitters.empty();
    std::optional<LitPoints> lit;
    if (files.has_emitters) lit.emplace(camera, world_surface(instances));
    std::array<std::vector<Lamp>, 2> lamp_sets;
    // Above POV-Ray's shadow tolerance.
    const float lift = static_cast<float>(0.01 / files.world_scale);
    for (const auto& [switched_off_by, cut_share, of_patch] :
         {std::tuple(second_dome_only, 0.5, PatchPlace::middle),
          std::tuple(first_dome_only, 0.4, PatchPlace::random)}) {
        const auto set = [&, cut_share = cut_share](int count, std::span<const Lamp> glowing) {
            LightSet made;
            for (const DirectionalLight& light :
                 light_dome(environment, {.lights = count, .cut_share = cut_share}))
                made.add(dome_light(light, distance));
            for (const Lamp& lamp : glowing) made.add(povray_lamp(lamp, files.world_scale, "Share") + "\n");
            return made;
        };
        std::vector<Lamp>& of_emitters = lamp_sets[of_patch == PatchPlace::random];
        of_emitters = emitter_lamps(emitters, std::size_t(lights / 2), of_patch, lift, lit ? &*lit : nullptr);
        const LightSet whole = set(lights / 2, of_emitters);
        files.lights += whole.count;
        text += fmt::format("#ifndef ({})\n", switched_off_by);
        // In one half of the reference, radiosity gathers the emitters' bounces without lamps.
        const bool has_lamps = of_patch == PatchPlace::middle;
        if (files.has_bounces && (lights > reduced_lights_of_bounces || (files.has_emitters && !has_lamps))) {
            const int few = std::min(lights, reduced_lights_of_bounces) / 2;
            const std::vector<Lamp> few_lamps =
                has_lamps ? emitter_lamps(emitters, std::size_t(few), of_patch, lift) : std::vector<Lamp>();
            text += fmt::format("#ifdef ({})\n{}#else\n{}#end\n", reduced_lights_alone,
                                set(few, few_lamps).text, whole.text);
        } else
            text += whole.text;
        text += "#end\n";
    }
    if (lit)
        files.emitter_lamps =
            std::make_shared<const LampSets>(LampSets{*std::move(lit), emitters, std::move(lamp_sets)});
    if (!lamps.empty()) {
        text += fmt::format("\n// The scene's lamps, which belong to both sets.\n#ifndef ({})\n",
                            emitters_by_radiosity);
        for (const Lamp& lamp : lamps) text += povray_lamp(lamp, files.world_scale) + "\n";
        text += "#end\n";
    }
    files.lamps = static_cast<int>(lamps.size());
    text += "#end\n";
    files.scene = folder / (scene_name + ".pov");
    HF_TRY_DONE(write_file(files.scene, text));
    return files;
}

std::vector<ReferenceInstance> reference_instances(const Scene& scene, const SceneEntities& originals) {
    std::vector<ReferenceInstance> instances;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const SceneEntity& entity = originals.of_instance(i);
        instances.push_back(
            {instance.name, &entity.mesh.original, entity.materials, instance.placement, entity.surfaces});
        if (std::ranges::any_of(entity.surfaces, &Surface::emits))
            instances.back().emitters = emitters_of(visible_surface(entity.mesh), entity.surfaces);
    }
    return instances;
}

}  // namespace haarfield
