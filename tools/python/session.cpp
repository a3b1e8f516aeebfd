/// Relighting sessions in Python: Scene.session.

#include "bridge/pictures/preview.h"
#include "scenes/entity_surfaces.h"
#include "scenes/scene_shading.h"
#include "shading/transfer/relight_session.h"
#include "tools/python/arrays.h"
#include "tools/python/images.h"
#include "tools/python/options.h"
#include "tools/python/scene.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

namespace haarfield::python {

namespace {

constexpr double degree = pi / 180;

/// Owner of the memory of radiance arrays: the session while its instances remain, then their last radiance.
struct RadianceOwner {
    std::shared_ptr<RelightSession> session;
    SceneColours last;  ///< Set when instances were cloned or removed.
};

/// A session that several threads may use, one at a time.
class PythonSession {
public:
    /// scene  the description of the prepared scene.
    PythonSession(std::shared_ptr<const PythonScene> scene, std::shared_ptr<const PreparedScene> prepared,
                  const RenderSettings& settings, const TransferSettings& transfer)
        : scene_(std::move(scene)),
          prepared_(std::move(prepared)),
          session_(std::make_shared<RelightSession>(
              shaded_scene(prepared_->scene, *prepared_->entities, prepared_->light.environment), settings,
              transfer)),
          shown_(std::make_shared<RadianceOwner>(RadianceOwner{session_, {}})) {
        for (const auto& entity : prepared_->entities->entities) surfaces_.push_back(entity->surfaces);
        session_->separate_components(has_separate_specular(*prepared_->entities));
        for (const Instance& instance : prepared_->scene.instances) names_.push_back(instance.name);
    }

    /// Runs a long call: transfer vectors or a commit.
    void do_long(const py::object& progress,
                 const std::function<Result<Done>(RelightSession&, const Progress&)>& act) {
        long_call<Done>(progress, [&](const Progress& watched) -> Result<Done> {
            const Turn turn(mutex_, watched);
            if (!turn) return interruption();
            return act(*session_, watched);
        });
    }

    /// Runs a short call, such as a change of the scene.
    template <class Act>
    auto do_now(const Act& act) {
        const py::gil_scoped_release released;
        const std::lock_guard lock(mutex_);
        return act(*session_);
    }

    // Takes milliseconds: runs in this thread, without Python's lock.
    void frame(bool is_moving) {
        const Result<Done> done = do_now([&](RelightSession& session) {
            return session.frame(is_moving ? FrameQuality::moving : FrameQuality::still, Progress());
        });
        value_of(done);
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }

    std::size_t clone(const py::object& instance, const std::string& name) {
        const std::size_t of = number_of(instance);
        let_go();
        const std::size_t made = do_now([&](RelightSession& session) { return session.clone(of); });
        names_.push_back(name.empty() ? fmt::format("{}_copy_{}", names_[of], ++copies_) : name);
        return made;
    }

    void remove(const py::object& instance) {
        const std::size_t of = number_of(instance);
        if (names_.size() == 1)
            throw py::value_error("this is the last instance; expected at least one instance in a session");
        let_go();
        do_now([&](RelightSession& session) { session.remove(of); });
        names_.erase(names_.begin() + static_cast<std::ptrdiff_t>(of));
    }

    py::list radiance() {
        const auto instances = do_now([](RelightSession& session) {
            const SceneColours& radiance = session.radiance();
            return std::vector<std::span<const Rgb>>(radiance.begin(), radiance.end());
        });
        py::list arrays;
        for (const std::span<const Rgb> instance : instances) arrays.append(view_of(instance, shown_));
        return arrays;
    }

    py::array picture() {
        const auto image = std::make_shared<Image>();
        long_call<Done>(py::none(), [&](const Progress& watched) -> Result<Done> {
            const Turn turn(mutex_, watched);
            if (!turn) return interruption();
            if (session_->radiance().size() != session_->instances().size())
                return Error{"", "found no radiance; expected a call of frame or commit first"};
            const LatLongImage background = image_with_suns(session_->scene().environment);
            Camera camera = prepared_->scene.camera;
            camera.position = session_->eye();
            std::vector<BakedInstance> instances = preview_instances(session_->scene(), session_->radiance());
            std::vector<LayeredRadiance> layers(instances.size());
            for (std::size_t i = 0; i < instances.size(); ++i) {
                const std::vector<Surface>& surfaces = surfaces_[session_->instances()[i].entity];
                if (all_plain(surfaces)) continue;
                layers[i] = layers_of(i);
                instances[i].radiance = layers[i].textured;
                instances[i].added = layers[i].added;
                instances[i].surfaces = surfaces;
            }
            *image = preview_.draw(camera, instances, [&](const Vec3f& direction) {
                return radiance_from(background, Vec3d(background_turn_.back(direction)));
            });
            return Done{};
        });
        return pixels_of(image);
    }

    /// Returns a layer of the displayed radiance by instance: the factor of the images, or the summand after
    /// it.
    py::list layer(bool is_over) {
        const auto layers = do_now([&](RelightSession& session) {
            std::vector<std::shared_ptr<LayeredRadiance>> all;
            for (std::size_t i = 0; i < session.radiance().size(); ++i)
                all.push_back(std::make_shared<LayeredRadiance>(layers_of(i)));
            return all;
        });
        py::list arrays;
        for (const auto& of : layers) {
            const std::vector<Rgb>& values = is_over ? of->added : of->textured;
            if (is_over && values.empty())
                arrays.append(py::none());
            else
                arrays.append(view_of(std::span<const Rgb>(values), of));
        }
        return arrays;
    }

    void set_lamps(const py::list& lamps) {
        const std::shared_ptr<const PythonScene> scene = scene_->changed(py::dict(py::arg("lights") = lamps));
        std::vector<Lamp> placed = lamps_of(scene->scene().lamps);
        for (Lamp& lamp : placed) {
            if (!lamp.looks_like) continue;
            const std::string& name = scene->scene().instances[*lamp.looks_like].name;
            const auto found = std::ranges::find(names_, name);
            if (found == names_.end()) throw py::key_error("there is no instance \"" + name + "\"");
            lamp.looks_like = static_cast<std::size_t>(found - names_.begin());
        }
        do_now([&](RelightSession& session) {
            session.set_lamps(std::move(placed));
            scene_ = scene;
        });
    }

    void set_material(const std::string& name, const py::dict& changes) {
        if (!scene_->scene().materials.contains(name))
            throw py::key_error("there is no material \"" + name + "\"");
        if (changes.contains("image"))
            throw py::value_error("found an image; expected none, as sessions keep images");
        py::dict material, materials;
        material[py::str(name)] = changes;
        materials["materials"] = material;
        const std::shared_ptr<const PythonScene> scene = scene_->changed(materials);
        do_now([&](RelightSession& session) {
            set_surfaces(session, scene->scene());
            scene_ = scene;
        });
    }

    void turn_environment(const Rotation& rotation) {
        do_now([&](RelightSession& session) {
            session.turn_environment(rotation);
            background_turn_ = rotation;
        });
    }

    void commit(const py::object& progress) {
        do_long(progress, [this](RelightSession& session, const Progress& watched) {
            Result<Done> done = session.commit(watched);
            if (done) background_turn_ = {};  // now part of the scene's environment
            return done;
        });
    }

    void place(const py::object& instance, const py::object& translate, const py::object& scale,
               const py::object& rotate) {
        const std::size_t of = number_of(instance);
        Placement placement =
            do_now([&](RelightSession& session) { return session.instances()[of].placement; });
        if (!translate.is_none()) placement.translate = vector(translate, "translate");
        if (!scale.is_none()) {
            placement.scale = scale.cast<float>();
            if (!(placement.scale >= 1e-6f && placement.scale <= 1e6f))
                throw py::value_error(fmt::format("scale is {}; expected [1e-06, 1e+06]", placement.scale));
        }
        if (!rotate.is_none())
            placement.rotate = rotation_xyz(vector(rotate, "rotate") * static_cast<float>(degree));
        do_now([&](RelightSession& session) { session.place(of, placement); });
    }

    std::size_t number_of(const py::object& instance) const {
        if (py::isinstance<py::str>(instance)) {
            const auto found = std::ranges::find(names_, instance.cast<std::string>());
            if (found == names_.end())
                throw py::key_error(fmt::format("unknown instance \"{}\"; expected one of {}",
                                                instance.cast<std::string>(), fmt::join(names_, ", ")));
            return static_cast<std::size_t>(found - names_.begin());
        }
        if (!py::isinstance<py::int_>(instance))
            throw py::type_error("instance is neither a str nor an int; expected a name or a number");
        const auto count = static_cast<py::ssize_t>(names_.size());
        const auto number = instance.cast<py::ssize_t>();
        if (number < -count || number >= count)
            throw py::index_error(fmt::format("instance {}; expected less than {}", number, count));
        return static_cast<std::size_t>(number < 0 ? number + count : number);
    }

    const std::vector<std::string>& names() const { return names_; }

private:
    LayeredRadiance layers_of(std::size_t instance) const {
        const std::size_t entity = session_->instances()[instance].entity;
        return layered_radiance(*session_->scene().entities[entity].mesh, surfaces_[entity],
                                session_->outgoing(instance));
    }

    /// Sets the materials of a changed description of the scene.
    void set_surfaces(RelightSession& session, const Scene& scene) {
        const SceneEntities& entities = *prepared_->entities;
        for (std::size_t i = 0; i < prepared_->scene.instances.size(); ++i) {
            const SceneEntity& entity = entities.of_instance(i);
            surfaces_[entities.entity_of_instance[i]] =
                with_scene_materials(scene, scene.entities[prepared_->scene.instances[i].entity],
                                     entity.mesh.fine.material_names, entity.surfaces);
        }
        bool separates = false;
        for (std::size_t e = 0; e < surfaces_.size(); ++e) {
            session.set_materials(e, materials_of(surfaces_[e]));
            session.set_emitters(e,
                                 std::ranges::any_of(surfaces_[e], &Surface::emits)
                                     ? emitters_of(visible_surface(entities.entities[e]->mesh), surfaces_[e])
                                     : std::vector<Emitter>());
            separates = separates || std::ranges::any_of(surfaces_[e], &Surface::has_separate_specular);
        }
        session.separate_components(separates);
    }

    /// Moves the radiance to the arrays that refer to it, so that their values no longer change.
    void let_go() {
        shown_->last = do_now([](RelightSession& session) { return session.take_radiance(); });
        shown_->session.reset();
        shown_ = std::make_shared<RadianceOwner>(RadianceOwner{session_, {}});
    }

    std::shared_ptr<const PythonScene> scene_;       ///< With the lamps and materials of the session.
    std::shared_ptr<const PreparedScene> prepared_;  ///< The session's pointers refer to it.
    std::vector<std::vector<Surface>> surfaces_;     ///< By entity.
    std::timed_mutex mutex_;
    std::shared_ptr<RelightSession> session_;
    std::shared_ptr<RadianceOwner> shown_;
    std::vector<std::string> names_;
    std::size_t copies_ = 0;
    Rotation background_turn_;  ///< Of the light, relative to the session's environment.
    Preview preview_;
};

}  // namespace

void add_session(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene) {
    py::class_<PythonSession> session(
        module, "Session",
        R"(An open scene whose radiance follows changes of the light, the eye and instances.

vary_light, vary_eye, vary_lamps and vary_instance compute the transfer vectors for changes of one input. After
that, frame takes milliseconds. commit shades the scene in full, as a bake does. An instance is identified by its
name or its index in `instances`. One thread at a time can use a session; others wait.)");
    session.def_property_readonly(
        "instances", [](const PythonSession& self) { return self.names(); },
        "The names of the current instances.");
    session.def(
        "vary_light",
        [](PythonSession& self, const py::object& progress) {
            self.do_long(progress,
                         [](RelightSession& of, const Progress& watched) { return of.vary_light(watched); });
        },
        py::arg("progress") = py::none(),
        "Computes the transfer vectors for frames with a rotating or replaced light.");
    session.def(
        "vary_eye",
        [](PythonSession& self, const py::object& progress) {
            self.do_long(progress,
                         [](RelightSession& of, const Progress& watched) { return of.vary_eye(watched); });
        },
        py::arg("progress") = py::none(), "Computes the transfer vectors for frames with a moving eye.");
    session.def(
        "vary_lamps",
        [](PythonSession& self, const py::object& progress) {
            self.do_long(progress,
                         [](RelightSession& of, const Progress& watched) { return of.vary_lamps(watched); });
        },
        py::arg("progress") = py::none(),
        "Shades everything but the lamps once, so that frames follow set_lamps.");
    session.def(
        "vary_instance",
        [](PythonSession& self, const py::object& instance, const py::object& progress) {
            const std::size_t of = self.number_of(instance);
            self.do_long(progress, [of](RelightSession& inside, const Progress& watched) {
                return inside.vary_instance(of, watched);
            });
        },
        py::arg("instance"), py::arg("progress") = py::none(),
        "Computes the transfer vectors for frames in which one instance moves or is scaled.");
    session.def(
        "turn_environment",
        [](PythonSession& self, double angle, const py::object& axis) {
            const Vec3f about = vector(axis, "axis");
            if (!std::isfinite(angle))
                throw py::value_error("angle is not finite; expected a number of degrees");
            if (!(about.length() > 0)) throw py::value_error("axis is (0, 0, 0); expected a direction");
            self.turn_environment(rotation_about(Vec3d(about), angle * degree));
        },
        py::arg("angle"), py::arg("axis") = py::make_tuple(0, 1, 0),
        "Rotates the scene's environment by degrees about an axis. Replaces earlier rotations.");
    session.def(
        "set_environment",
        [](PythonSession& self, const py::object& pixels) {
            const FloatArray array = floats(pixels, "pixels", {any_length, any_length, 3});
            if (array.shape(0) == 0 || array.shape(1) != 2 * array.shape(0))
                throw py::value_error(fmt::format("pixels has the shape {}; expected (height, 2 height, 3)",
                                                  shape_text(array)));
            LatLongImage image{static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)), {}};
            for (py::ssize_t i = 0; i < array.size(); i += 3)
                image.pixels.emplace_back(array.data()[i], array.data()[i + 1], array.data()[i + 2]);
            clean_environment(image);
            self.turn_environment({});
            self.do_now([&](RelightSession& of) { of.set_environment(Environment(std::move(image))); });
        },
        py::arg("pixels"),
        "Replaces the light by a lat-long image of radiance, (height, 2 height, 3). Resets the rotation.");
    session.def(
        "set_eye",
        [](PythonSession& self, const py::object& position) {
            const Vec3f eye = vector(position, "position");
            self.do_now([&](RelightSession& of) { of.set_eye(eye); });
        },
        py::arg("position"), "Moves the eye, on which specular radiance depends, to (x, y, z) metres.");
    session.def("set_lamps", &PythonSession::set_lamps, py::arg("lamps"),
                "Replaces the lamps by a list of dicts with the keys of `lights` in a scene file.");
    session.def("set_material", &PythonSession::set_material, py::arg("name"), py::arg("changes"),
                "Changes the keys of a material of the scene, named as in a scene file. Images remain.");
    session.def(
        "place", &PythonSession::place, py::arg("instance"), py::arg("translate") = py::none(),
        py::arg("scale") = py::none(), py::arg("rotate") = py::none(),
        "Places an instance: translate (x, y, z) in metres, scale, and rotate, degrees about x, then y,\n"
        "then z. None keeps the current value.");
    session.def(
        "rotate",
        [](PythonSession& self, const py::object& instance, const py::object& axis, double angle) {
            const std::size_t of = self.number_of(instance);
            const Vec3f about = vector(axis, "axis");
            if (!(about.length() > 0)) throw py::value_error("axis is (0, 0, 0); expected a direction");
            if (!std::isfinite(angle))
                throw py::value_error("angle is not finite; expected a number of degrees");
            self.do_now([&](RelightSession& inside) { inside.rotate(of, Vec3d(about), angle * degree); });
        },
        py::arg("instance"), py::arg("axis"), py::arg("angle"),
        "Rotates an instance further by degrees about an axis through its origin.");
    session.def("clone", &PythonSession::clone, py::arg("instance"), py::arg("name") = "",
                "Copies an instance to the same place. Returns its index, the last one.");
    session.def("remove", &PythonSession::remove, py::arg("instance"),
                "Removes an instance. The indices of later ones decrease by one.");
    session.def(
        "frame", &PythonSession::frame, py::arg("moving") = false,
        "Computes the current radiance by the transfer vectors. moving: faster, for use during motion.");
    session.def("commit", &PythonSession::commit, py::arg("progress") = py::none(),
                "Computes the current radiance in full, bit-identical to a bake.");
    session.def_property_readonly(
        "radiance", &PythonSession::radiance,
        R"(A list with an array for each instance, (N, 3), outgoing and linear, W/(m^2 sr).

They are the session's own memory, which each frame and commit updates. When an instance is cloned or removed,
existing arrays keep their values. As in bakes, they do not include the images of textures: see under and over.)");
    session.def_property_readonly(
        "under", [](PythonSession& self) { return self.layer(false); },
        "A list with an array for each instance: the radiance that images multiply, as BakedMesh.under. "
        "Copies.");
    session.def_property_readonly(
        "over", [](PythonSession& self) { return self.layer(true); },
        "A list with an array for each instance, or None: the radiance on top of images, as BakedMesh.over. "
        "Copies.");
    session.def_property_readonly(
        "matrices",
        [](PythonSession& self) {
            const auto instances = self.do_now([](RelightSession& of) { return of.instances(); });
            py::list matrices;
            for (const ShadedInstance& instance : instances) matrices.append(matrix_of(instance.placement));
            return matrices;
        },
        "A list with the matrix of each instance: (4, 4), from its frame to the world.");
    session.def("picture", &PythonSession::picture,
                "(height, width, 3): a quick picture from the eye, drawn without POV-Ray.");
    session.def_property_readonly(
        "transfer_bytes",
        [](PythonSession& self) {
            return self.do_now([](RelightSession& of) { return of.transfer_bytes(); });
        },
        "The memory of the transfer vectors, in bytes.");
    static constexpr auto varying = {OptionSet::frames, OptionSet::occlusion, OptionSet::lighting};
    py::options undocumented;
    undocumented.disable_function_signatures();
    scene.def(
        "session",
        [](const std::shared_ptr<PythonScene>& self, const py::object& progress, const py::kwargs& options) {
            RenderChoices choices = render_choices(options, varying, "Scene.session");
            const auto prepared = prepare(*self, progress);
            choices.shading.face_size = prepared->face_size;
            apply_bounces(prepared->scene, choices.shading.bounces);
            return std::make_unique<PythonSession>(self, prepared, choices.shading, choices.transfer);
        },
        py::arg("progress") = py::none(),
        option_docstring("session", "", varying, "haarfield._haarfield.Session",
                         "Holds the scene open for changes; see Session.")
            .c_str());
}

}  // namespace haarfield::python
