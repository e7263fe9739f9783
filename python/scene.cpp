// Scenes from Python: loaded from a file or made of arrays, and edited.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "editor/session/file/content_hash.h"
#include "editor/session/settings/as_input.h"
#include "python/bindings.h"
#include "renderer/scene/gltf/still_scene.h"

namespace raygraph::python {

using namespace session;

void Scene::Update() {
    if (!isEdited) return;
    scene::UpdateWorldTransforms(input.data);
    input.statistics = scene::Statistics(input.data);
    input.hash = HashOf(input.data);
    isEdited = false;
}

SceneInput Scene::InputFor(bool isAnimated) const {
    SceneInput copy = input;
    copy.isAnimated = isAnimated;
    if (!isAnimated) AsInput([&] { scene::FreezePose(copy.data, {}); });
    return copy;
}

namespace {

std::shared_ptr<Scene> Load(const std::filesystem::path& path, std::string sceneName, std::string variant,
                            const std::string& points, const std::string& lines,
                            std::filesystem::path environment, std::filesystem::path root) {
    InputOptions options{.scene = std::move(sceneName), .variant = std::move(variant), .isAnimated = true};
    options.pointsAndLines = {scene::ParseRoundRadius(points), scene::ParseRoundRadius(lines)};
    options.root = std::move(root);
    options.environment = std::move(environment);
    options.log = LogToPython();
    return WithoutGil([&] {
        auto loaded = std::make_shared<Scene>();
        loaded->input = LoadInput(path, options);
        return loaded;
    });
}

}  // namespace

void BindScene(py::module_& module) {
    py::class_<Scene, std::shared_ptr<Scene>>(module, "Scene",
                                              "A scene, to be rendered and edited. Units are those of glTF: "
                                              "meters, radians, candela and lux; +y is up.")
        .def_property_readonly("file", [](const Scene& scene) { return scene.input.file; });
    module.def("load", &Load);
}

}  // namespace raygraph::python
