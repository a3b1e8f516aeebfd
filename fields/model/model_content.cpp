#include "fields/model/model_content.h"

#include "fields/mesh/mesh.h"

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

constexpr std::uint32_t content_magic = 0x4d524148;  // "HARM"

void write_image(const MeshImage& image, ByteSink& sink) {
    sink.text(image.name);
    sink.value(std::uint8_t(image.bytes != nullptr));
    if (image.bytes) sink.text(*image.bytes);
}

MeshImage image_from(ByteSource& source) {
    MeshImage image;
    image.name = source.text();
    if (source.value<std::uint8_t>()) image.bytes = std::make_shared<const std::string>(source.text());
    return image;
}

/// The numeric properties of a material.
struct MaterialNumbers {
    std::array<float, 13> numbers;
    std::array<std::uint8_t, 2> model_and_alpha;
};

MaterialNumbers numbers_of(const MeshMaterial& m) {
    return {{m.diffuse.x, m.diffuse.y, m.diffuse.z, m.specular.x, m.specular.y, m.specular.z, m.emission.x,
             m.emission.y, m.emission.z, m.exponent, m.metallic, m.roughness, m.alpha_cutoff},
            {static_cast<std::uint8_t>(m.model), static_cast<std::uint8_t>(m.alpha)}};
}

/// Sets the numeric properties. False if a number is out of range.
bool take_numbers(const MaterialNumbers& taken, MeshMaterial& m) {
    const auto& n = taken.numbers;
    constexpr float brightest = 1e12f;
    if (!std::ranges::all_of(n, [](float number) { return number >= 0 && number <= brightest; }) ||
        taken.model_and_alpha[0] > static_cast<std::uint8_t>(MeshMaterial::Model::by_colour) ||
        taken.model_and_alpha[1] > static_cast<std::uint8_t>(AlphaMode::blend))
        return false;
    m.diffuse = Rgb(n[0], n[1], n[2]);
    m.specular = Rgb(n[3], n[4], n[5]);
    m.emission = Rgb(n[6], n[7], n[8]);
    m.exponent = n[9];
    m.metallic = n[10];
    m.roughness = n[11];
    m.alpha_cutoff = n[12];
    m.model = static_cast<MeshMaterial::Model>(taken.model_and_alpha[0]);
    m.alpha = static_cast<AlphaMode>(taken.model_and_alpha[1]);
    const auto is_share = [](const Rgb& colour) { return std::max({colour.x, colour.y, colour.z}) <= 1; };
    return is_share(m.diffuse) && is_share(m.specular) && m.metallic <= 1 && m.roughness <= 1 &&
           m.alpha_cutoff <= 1;
}

bool is_whole(const ContentListing& listing) {
    std::uint64_t corners = 0;
    for (const std::uint32_t count : listing.face_corners) corners += count;
    return listing.positions.size() <= INT32_MAX && corners == listing.corners.size() &&
           std::ranges::all_of(listing.corners,
                               [&](std::uint32_t corner) { return corner < listing.positions.size(); });
}

/// Tests whether the numbers of a mesh are valid for a listing. Without a listing, there must be none.
bool is_numbered(const ContentMesh& mesh, const std::optional<ContentListing>& listing) {
    if (!listing) return mesh.numbers.empty() && mesh.faces.empty();
    const auto vertices = static_cast<std::int64_t>(listing->positions.size());
    return mesh.numbers.size() == mesh.positions.size() &&
           std::ranges::all_of(mesh.numbers,
                               [&](std::int32_t n) { return n >= not_original && n < vertices; }) &&
           std::ranges::all_of(mesh.faces,
                               [&](std::uint32_t face) { return face < listing->face_corners.size(); });
}

bool is_whole(const ContentMesh& mesh, std::size_t materials) {
    const std::size_t vertices = mesh.positions.size();
    const auto fits = [vertices](std::size_t count) { return count == 0 || count == vertices; };
    std::uint64_t corners = 0;
    for (const std::uint32_t count : mesh.face_corners) corners += count;
    return (mesh.material < materials || mesh.material == ContentMesh::no_material) &&
           fits(mesh.normals.size()) && fits(mesh.uvs.size()) && fits(mesh.colours.size()) &&
           (mesh.face_corners.empty() ? mesh.corners.size() % 3 == 0 : corners == mesh.corners.size());
}

struct LightNumbers {
    std::uint32_t kind = 0, is_physical = 0;
    Vec3f position, target;
    Rgb colour;
    float radius = 0, falloff = 0;
};

bool take_numbers(const LightNumbers& numbers, ModelLight& light) {
    light.kind = static_cast<ModelLight::Kind>(numbers.kind);
    light.is_physical = numbers.is_physical != 0;
    light.position = numbers.position;
    light.target = numbers.target;
    light.colour = numbers.colour;
    light.radius = numbers.radius;
    light.falloff = numbers.falloff;
    return numbers.kind <= std::uint32_t(ModelLight::Kind::parallel) && numbers.is_physical <= 1 &&
           is_light(light);
}

}  // namespace

bool is_light(const ModelLight& light) {
    const float least = std::min({light.colour.x, light.colour.y, light.colour.z});
    return least >= 0 && is_finite(light.colour) && is_finite(light.position) &&
           (light.target - light.position).length() > 0 && light.radius >= 0 &&
           light.radius <= light.falloff && light.falloff > 0 && light.falloff < 3.1416f;
}

void write_content(const ModelContent& content, ByteSink& sink) {
    sink.value(content_magic);
    sink.value(std::uint64_t(content.materials.size()));
    for (const ContentMaterial& material : content.materials) {
        sink.text(material.name);
        sink.value(numbers_of(material.description));
        for (const MeshImage* image : {&material.description.image, &material.description.surface_map,
                                       &material.description.opacity_map})
            write_image(*image, sink);
        sink.value(std::uint64_t(material.unused.size()));
        for (const std::string& what : material.unused) sink.text(what);
    }
    sink.value(std::uint64_t(content.meshes.size()));
    for (const ContentMesh& mesh : content.meshes) {
        sink.text(mesh.name);
        sink.value(mesh.material);
        sink.values(mesh.positions);
        sink.values(mesh.normals);
        sink.values(mesh.uvs);
        sink.values(mesh.colours);
        sink.values(mesh.face_corners);
        sink.values(mesh.corners);
        sink.values(mesh.numbers);
        sink.values(mesh.faces);
    }
    sink.value(std::uint64_t(content.nodes.size()));
    for (const ContentNode& node : content.nodes) {
        sink.text(node.name);
        sink.value(node.transform);
        sink.values(node.meshes);
    }
    sink.value(std::uint8_t(content.camera.has_value()));
    if (content.camera) {
        sink.value(content.camera->position);
        sink.value(content.camera->direction);
        sink.value(content.camera->vertical_fov.value_or(0));
    }
    sink.value(std::uint64_t(content.lights.size()));
    for (const ModelLight& light : content.lights) {
        sink.text(light.name);
        sink.value(LightNumbers{std::uint32_t(light.kind), light.is_physical ? 1u : 0u, light.position,
                                light.target, light.colour, light.radius, light.falloff});
    }
    sink.value(std::uint8_t(content.listing.has_value()));
    if (content.listing) {
        sink.values(content.listing->positions);
        sink.values(content.listing->corners);
        sink.values(content.listing->face_corners);
    }
}

Result<ModelContent> content_from(std::string_view bytes) {
    const Error wrong{"", "its reader returned invalid data: the file is damaged"};
    ByteSource source(bytes);
    ModelContent content;
    if (source.value<std::uint32_t>() != content_magic) return wrong;
    // Every item contains at least its counts, which limits the number of items by the number of bytes.
    content.materials.resize(source.count(sizeof(MaterialNumbers)));
    for (ContentMaterial& material : content.materials) {
        material.name = source.text();
        if (!take_numbers(source.value<MaterialNumbers>(), material.description)) return wrong;
        for (MeshImage* image : {&material.description.image, &material.description.surface_map,
                                 &material.description.opacity_map})
            *image = image_from(source);
        material.unused.resize(source.count(sizeof(std::uint64_t)));
        for (std::string& what : material.unused) what = source.text();
        if (!source.is_good()) return wrong;
    }
    content.meshes.resize(source.count(9 * sizeof(std::uint64_t)));
    for (ContentMesh& mesh : content.meshes) {
        mesh.name = source.text();
        mesh.material = source.value<std::uint32_t>();
        mesh.positions = source.values<Vec3f>();
        mesh.normals = source.values<Vec3f>();
        mesh.uvs = source.values<Vec2f>();
        mesh.colours = source.values<Rgb>();
        mesh.face_corners = source.values<std::uint32_t>();
        mesh.corners = source.values<std::uint32_t>();
        mesh.numbers = source.values<std::int32_t>();
        mesh.faces = source.values<std::uint32_t>();
        if (!source.is_good() || !is_whole(mesh, content.materials.size())) return wrong;
    }
    content.nodes.resize(source.count(2 * sizeof(std::uint64_t)));
    for (ContentNode& node : content.nodes) {
        node.name = source.text();
        node.transform = source.value<std::array<float, 16>>();
        node.meshes = source.values<std::uint32_t>();
        if (!source.is_good() || node.meshes.empty() ||
            std::ranges::any_of(node.meshes,
                                [&](std::uint32_t mesh) { return mesh >= content.meshes.size(); }))
            return wrong;
    }
    if (source.value<std::uint8_t>()) {
        ModelCamera camera;
        camera.position = source.value<Vec3f>();
        camera.direction = source.value<Vec3f>();
        const float fov = source.value<float>();
        if (!is_finite(camera.position) || !is_finite(camera.direction) || !(camera.direction.length() > 0))
            return wrong;
        if (fov > 0.01f && fov < 3) camera.vertical_fov = fov;
        content.camera = camera;
    }
    content.lights.resize(source.count(sizeof(LightNumbers)));
    for (ModelLight& light : content.lights) {
        light.name = source.text();
        if (!take_numbers(source.value<LightNumbers>(), light) || !source.is_good()) return wrong;
    }
    if (source.value<std::uint8_t>()) {
        ContentListing listing;
        listing.positions = source.values<Vec3f>();
        listing.corners = source.values<std::uint32_t>();
        listing.face_corners = source.values<std::uint32_t>();
        if (!source.is_good() || !is_whole(listing)) return wrong;
        content.listing = std::move(listing);
    }
    if (!source.is_at_end() || !std::ranges::all_of(content.meshes, [&](const ContentMesh& mesh) {
            return is_numbered(mesh, content.listing);
        }))
        return wrong;
    return content;
}

}  // namespace haarfield
