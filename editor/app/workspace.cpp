#include "editor/app/workspace.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <glm/gtc/constants.hpp>
#include <iterator>
#include <set>
#include <utility>

#include "base/files.h"
#include "base/text.h"
#include "editor/app/render_words.h"
#include "editor/session/file/content_hash.h"
#include "editor/session/settings/parse.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/gltf/still_scene.h"
#include "renderer/scene/model/variants.h"

namespace raygraph::editor {

bool Workspace::IsEnvironment(const std::filesystem::path& file) {
    const std::string extension = LowerExtension(file);
    return extension == ".hdr" || extension == ".exr";
}

void Workspace::Open(const std::filesystem::path& file, const std::string& variant,
                     const ChangeView& changeView) {
    if (IsEnvironment(file)) {
        OpenEnvironment(file);
        return;
    }
    if (!loader.Start(file, variant, pointsAndLines, changeView, root))
        ShowMessage("another scene is being loaded");
}

template <typename Change>
bool Workspace::Try(Change&& change) {
    try {
        change();
        return true;
    } catch (
        // Neither an Error nor an exception of a library closes the open scene
        const std::exception& error) {
        ReportError(error.what());
        return false;
    }
}

void Workspace::ShowMessage(std::string text, bool isError) {
    message = std::move(text);
    isMessageError = isError;
    messageAge = 0.0f;
}

void Workspace::ReportError(const std::string& why, std::string_view category) {
    ShowMessage(why, true);
    device.Log().Send(LogLevel::Warning, category, why);
}

void Workspace::ReportErrorOnce(const std::string& why, std::string& last, std::string_view category) {
    if (why == last)
        ShowMessage(why, true);
    else
        ReportError(last = why, category);
}

void Workspace::Apply(std::span<const Edit> edits) {
    try {
        document.Apply(edits, gpu);
        m_refusedEdit.clear();
    } catch (const std::exception& error) {
        ReportErrorOnce(error.what(), m_refusedEdit);
    }
}

void Workspace::PickFocus(bool isOn) {
    m_isPickingFocus = isOn;
    if (isOn) ShowMessage("click on what is to be in focus; Escape cancels");
}

void Workspace::FocusOn(glm::uvec2 pixel) {
    m_isPickingFocus = false;
    m_focusRequest = view.RequestPick(pixel);
}

void Workspace::FinishFocus() {
    if (!m_focusRequest || !m_focusRequest->IsReady()) return;
    const viewport::PickResult found = m_focusRequest->Result();
    m_focusRequest.reset();
    if (!found.isHit)
        return ShowMessage(Text("nothing is seen there; the focus stays at {:.4g} m", FocusDistance()));
    focus = found.depth;
    ShowMessage(Text("in focus: {:.4g} m{}", focus,
                     aperture > 0.0f ? "" : "; all is sharp until the lens has an aperture"));
}

float Workspace::FocusDistance() const {
    return focus > 0.0f ? focus : session::DefaultFocus(camera.View(), document.Scene().bounds);
}

viewport::LensSettings Workspace::Lens() const {
    const bool hasLens = aperture > 0.0f && camera.View().projection == scene::Projection::Perspective;
    return hasLens ? viewport::LensSettings{aperture, FocusDistance()} : viewport::LensSettings{};
}

std::optional<passes::BackdropSettings> Workspace::ShownBackdrop() const {
    const EnvironmentSettings shown = gpu.ShownEnvironment();
    const bool hasMap = !m_environmentFile.empty() || shown.defaultLight == DefaultLight::Studio ||
                        (shown.usesScene && HasSceneEnvironment());
    if (backdrop && !backdrop->color && !hasMap) return passes::BackdropSettings{};
    return backdrop;
}

void Workspace::ShowBackdrop() {
    if (document.Clips().empty()) m_restBounds = document.Scene().bounds;
    gpu.SetGround(hasGround ? m_restBounds : scene::Bounds{});
    const std::optional<passes::BackdropSettings> shown = ShownBackdrop();
    viewport::PathSettings paths = view.Paths();
    paths.isEnvironmentHidden = hasGround || shown != passes::BackdropSettings{};
    view.SetPaths(paths);
    viewport::ShowSettings show = view.Show();
    show.tonemap.isUnassociated = !shown;
    show.backdrop = shown;
    view.SetShow(show);
}

void Workspace::SetWhitePoint(int kelvin) {
    m_whitePoint = kelvin;
    viewport::ShowSettings show = view.Show();
    show.tonemap.whiteBalance = passes::WhiteBalance(passes::WhitePointAt(double(kelvin)));
    view.SetShow(show);
}

void Workspace::ToggleVisibility() {
    if (!selectedNode) return;
    const bool isVisible = !document.Scene().nodes[*selectedNode].isVisible;
    std::vector<Edit> edits;
    for (const uint32_t node : selectedNodes) edits.push_back(VisibilityEdit{node, isVisible});
    document.Settle();
    Apply(edits);
    document.Settle();
}

void Workspace::DuplicateSelection() {
    if (selectedNodes.empty()) return;
    std::vector<uint32_t> copies;
    if (!Try([&] { copies = document.Duplicate(selectedNodes, gpu); })) return;
    FollowHierarchy();
    nodeToReveal = copies.back();
    ShowMessage(copies.size() == 1 ? Text("duplicated as '{}'", document.NameOf(copies.back()))
                                   : Text("duplicated {} nodes", copies.size()));
    SelectAll(std::move(copies));
}

void Workspace::AddNode(const char* name, const glm::dvec3& place, bool isTurned,
                        std::optional<scene::Light> light, std::optional<scene::Camera> seen) {
    const scene::CameraView& from = camera.View();
    const scene::FloatPair translation = scene::ToFloatPair(place);
    scene::Node node;
    node.name = name;
    node.translation = translation.rounded;
    node.translationResidual = translation.rest;
    if (isTurned)
        node.rotation = glm::normalize(glm::quat_cast(glm::mat3(from.right, from.up, -from.forward)));
    uint32_t added = 0;
    if (!Try([&] { added = document.Add(node, std::move(light), std::move(seen), gpu); })) return;
    FollowHierarchy();
    Select(added);
    nodeToReveal = added;
    ShowMessage(Text("added '{}'", document.NameOf(added)));
}

void Workspace::AddLight(scene::LightType type) {
    const float distance = 0.5f * camera.Distance();
    scene::Light light{.type = type};
    light.intensity = glm::pi<float>();
    if (type != scene::LightType::Directional) light.intensity *= distance * distance;
    const char* const name = type == scene::LightType::Point  ? "Point light"
                             : type == scene::LightType::Spot ? "Spot light"
                                                              : "Directional light";
    const glm::dvec3 place = camera.View().eye + glm::dvec3(distance * camera.View().forward);
    AddNode(name, place, type != scene::LightType::Point, light, {});
}

void Workspace::AddEmpty() {
    AddNode("Empty", camera.Pivot(), false, {}, {});
}

void Workspace::AddCamera() {
    constexpr float kFar = 100.0f;  // in distances to the pivot; glTF has no infinite orthographic camera
    const scene::CameraView& from = camera.View();
    scene::Camera seen{.projection = from.projection, .yFov = from.yFov, .aspectRatio = from.aspect};
    seen.yMag = 0.5f * from.height;
    seen.xMag = seen.yMag * from.aspect;
    seen.zNear = from.zNear;
    if (from.projection == scene::Projection::Orthographic)
        seen.zFar = std::max(from.zFar, kFar * camera.Distance());
    AddNode("Camera", from.eye, true, {}, seen);
}

void Workspace::DeleteSelection() {
    const std::vector<uint32_t> tops = document.Tops(selectedNodes);
    if (tops.empty()) return;
    const uint32_t parent = document.Scene().nodes[tops.back()].parent;
    Document::Removed removed;
    if (!Try([&] { removed = document.Remove(tops, gpu); })) return;
    Select(parent == scene::kNone ? std::nullopt : std::optional(parent));
    FollowHierarchy();
    std::string text = Text("deleted {}", Counted(removed.nodes, "node"));
    if (removed.channels > 0) text += Text(", {} with it", Counted(removed.channels, "animation channel"));
    ShowMessage(std::move(text));
}

void Workspace::Reparent(uint32_t node, std::optional<uint32_t> parent) {
    const std::vector<uint32_t> nodes = IsSelected(node) ? selectedNodes : std::vector{node};
    if (!Try([&] { document.Reparent(nodes, parent.value_or(scene::kNone), scene::kNone, gpu); })) return;
    FollowHierarchy();
    nodeToReveal = node;
    const std::string moved =
        nodes.size() == 1 ? Text("'{}' is", document.NameOf(node)) : Text("{} nodes are", nodes.size());
    const std::string place = parent              ? Text("below '{}'", document.NameOf(*parent))
                              : nodes.size() == 1 ? "a root"
                                                  : "roots";
    ShowMessage(Text("{} {}", moved, place));
}

void Workspace::Rename(uint32_t node, const std::string& name) {
    if (name == document.Scene().nodes[node].name) return;
    document.Settle();
    Apply(NameEdit{node, name});
    document.Settle();
    FollowHierarchy();
}

std::string Workspace::ReplaceImage(uint32_t texture, const std::filesystem::path& file) {
    std::string why;
    try {
        document.ReplaceImage(texture, file, gpu);
        ShowMessage(Text("the image is {} now", file.filename()));
    } catch (const std::exception& error) {
        ReportError(why = error.what());
    }
    return why;
}

void Workspace::StartRename() {
    if (!selectedNode) return;
    panels.hierarchy = true;
    nodeToReveal = selectedNode;
    const std::string name = document.NameOf(*selectedNode);
    nameDraft = NameDraft{.node = *selectedNode};
    size_t size = std::min(name.size(), nameDraft->text.size() - 1);
    while (size < name.size() && size > 0 && (name[size] & 0xc0) == 0x80) --size;  // a character is whole
    std::copy_n(name.begin(), size, nameDraft->text.begin());
    nameDraft->initial = nameDraft->text;
}

void Workspace::FollowHierarchy() {
    hierarchy.Update(document.Children(), document.Roots());
    FilterHierarchy(m_hierarchyFilter);
    if (nameDraft && !document.IsPresent(nameDraft->node)) nameDraft.reset();
    if (m_chosenCamera) {
        const uint32_t node = document.Scene().cameras[m_chosenCamera->camera].node;
        if (node != scene::kNone && !document.IsPresent(node)) m_chosenCamera.reset();
    }
    if (!std::ranges::all_of(selectedNodes, [&](uint32_t node) { return document.IsPresent(node); }))
        SelectAll(selectedNodes);
}

void Workspace::ShowVariant(uint32_t variant) {
    Try([&] { document.ShowVariant(variant, gpu); });
}

void Workspace::Undo() {
    if (Try([&] { document.Undo(gpu); })) FollowHistory();
}

void Workspace::Redo() {
    if (Try([&] { document.Redo(gpu); })) FollowHistory();
}

void Workspace::FollowHistory() {
    FollowHierarchy();
    if (document.Restored().empty()) return;
    SelectAll(document.Restored());
    nodeToReveal = selectedNode;
}

bool Workspace::SaveScene(const std::filesystem::path& file) {
    const bool isSaved = Try([&] {
        document.Save(file);
        AddRecentFile(file);
        ShowMessage(Text("saved {}", file));
    });
    if (!isSaved) return false;
    try {
        StoreView(file);
    } catch (const Error& error) {
        ReportError(Text("saved {}, but not its view: {}", file, error.what()));
    }
    return true;
}

void Workspace::StoreView(const std::filesystem::path& file) {
    WriteView(file, ShownView());
    const SceneView plain;
    if (!m_lookBefore) m_lookBefore = Look{plain.exposureEv, plain.tonemap, plain.whitePoint};
    m_lookOfScene = ShownLook();
}

void Workspace::SaveView() {
    const std::filesystem::path file = document.File();
    Try([&] {
        StoreView(file);
        ShowMessage(Text("saved the view: {}", ViewFileOf(file)));
    });
}

void Workspace::AddRecentFile(const std::filesystem::path& file) {
    Settings settings;
    settings.recent = std::move(recent);
    settings.AddRecentFile(file);
    recent = std::move(settings.recent);
}

void Workspace::Observe() {
    for (const FrameTiming& timing : renderer.TakeTimings()) history.Add(timing);
    const double now =
        std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    const viewport::ViewportProgress progress = view.Progress();
    sampleRate.Add(now, progress.pathTracedSamples + progress.pathTracedFraction);
    if (estimate.sampleCount > progress.pathTracedSamples + 1)
        estimate = {};  // belongs to a picture that is gone
    if (m_errorRequest && m_errorRequest->IsReady()) {
        estimate = m_errorRequest->Result();
        m_errorRequest.reset();
    }
    ObserveRealTime(now);
    explained.Observe(view, document.Scene());
    FinishFocus();
    // An estimate costs little, but not nothing
    if (!panels.statistics || m_errorRequest || now - m_errorRequestTime < 0.5) return;
    m_errorRequest = view.RequestNoise();
    m_errorRequestTime = now;
}

void Workspace::ObserveRealTime(double now) {
    // FLIP takes longer than the frame itself on some devices
    const double period = std::max(0.1, 4.0 * 1e-3 * view.LastFrameMs());
    if (!panels.statistics || !viewport::ComparesRealTime(view.Show())) {
        realTimeErrors = {};
        return;
    }
    if (m_realTimeRequest && m_realTimeRequest->IsReady()) {
        realTimeErrors.Add(m_realTimeRequest->Result());
        m_realTimeRequest.reset();
    }
    if (m_realTimeRequest || now - m_realTimeRequestTime < period) return;
    m_realTimeRequest = view.RequestRealTimeErrors();
    m_realTimeRequestTime = now;
}

void Workspace::ChooseViewByTime() {
    m_isChoosingView = true;
    m_ownView = view.Show();
}

void Workspace::ContinueChoosingView() {
    constexpr uint32_t kFrames = 16;  // the real-time view stops filtering after as many still ones
    if (!m_isChoosingView) return;
    viewport::ShowSettings show = view.Show();
    if (show.view != m_ownView->view) {  // the user has chosen
        m_isChoosingView = false;
        return;
    }
    // With a hidden environment, there is no real-time view to be measured
    if (document.File().empty() || IsLoading() || view.Paths().isEnvironmentHidden) return;
    const viewport::ViewportProgress progress = view.Progress();
    if (show.view != viewport::View::RealTime) {
        show.view = viewport::View::RealTime;
        m_realTimeFramesBefore = progress.realTimeFrames;
    } else {
        if (progress.realTimeFrames < m_realTimeFramesBefore + kFrames) return;
        m_isChoosingView = false;
        const bool isFast = progress.realTimeMs && *progress.realTimeMs <= kMostRealTimeMs;
        if (!isFast) {
            show.view = viewport::View::PathTraced;
            show.isDenoised = true;
        }
        const std::string took =
            progress.realTimeMs ? Text("{:.1f} ms", *progress.realTimeMs) : "unknown time";
        device.Log().Send(
            LogLevel::Info, log_category::kDevice,
            Text("the view is {}: a real-time frame of {}x{} takes {}, at most {} ms are wanted",
                 isFast ? "real-time" : "path-traced and denoised", view.Size().width, view.Size().height,
                 took, kMostRealTimeMs));
    }
    view.SetShow(show);
    m_ownView = show;
}

void Workspace::Take(const Settings& settings) {
    panels = settings.panels;
    panelSizes = settings.panelSizes;
    keys = settings.keys;
    tool = settings.tool;
    toolSpace = settings.toolSpace;
    pivot = settings.pivot;
    recent = settings.recent;
    viewport::ShowSettings show = settings.show;
    show.view = settings.view.value_or(show.view);
    view.SetShow(show);
    SetWhitePoint(settings.whitePoint);
    viewport::BudgetSettings budget = view.Budget();
    budget.whileMoving = settings.whileMoving;
    view.SetBudget(budget);
}

Settings Workspace::SettingsToSave() const {
    Settings settings;
    settings.panels = panels;
    settings.panelSizes = panelSizes;
    settings.keys = keys;
    settings.tool = tool;
    settings.toolSpace = toolSpace;
    settings.pivot = pivot;
    settings.recent = recent;
    // The user cannot set the other fields here
    const viewport::ShowSettings& show = view.Show();
    if (!m_ownView || show.view != m_ownView->view || show.isDenoised != m_ownView->isDenoised)
        settings.view = show.view;
    settings.show.compared = show.compared;
    settings.show.isDenoised = show.isDenoised;
    settings.show.wipePosition = show.wipePosition;
    const Look look = OwnLook();
    settings.show.tonemap.exposureEv = look.exposureEv;
    settings.show.tonemap.tonemapOperator = look.tonemap;
    settings.whitePoint = look.whitePoint;
    settings.show.maxError = show.maxError;
    settings.whileMoving = view.Budget().whileMoving;
    return settings;
}

void Workspace::OpenEnvironment(const std::filesystem::path& file,
                                const std::optional<EnvironmentSettings>& settings) {
    m_missingMap.reset();
    m_nextMap.reset();
    if (m_environment.valid()) {
        m_isLoadStale = m_loadingMap.file != file;
        (m_isLoadStale ? m_nextMap.emplace() : m_loadingMap) = {file, settings};
        return;
    }
    m_loadingMap = {file, settings};
    ShowMessage(Text("loading {} ...", file));
    m_environment = std::async(std::launch::async, [file] {
        LoadedEnvironment loaded{.map = image::ReadEnvironment(file), .hash = {}};
        loaded.hash = session::HashOf(loaded.map.image);
        return loaded;
    });
}

void Workspace::FinishLoadingEnvironment() {
    if (!m_environment.valid() ||
        m_environment.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
        return;
    const bool isStale = std::exchange(m_isLoadStale, false);
    const bool isShown = isStale || Try([&] {
                             const LoadedEnvironment environment = m_environment.get();
                             const image::Environment& loaded = environment.map;
                             gpu.SetEnvironmentMap(loaded.image);
                             gpu.SetEnvironment(SettingsFor(m_loadingMap));
                             m_environmentFile = m_loadingMap.file;
                             m_environmentHash = environment.hash;
                             for (const std::string& warning : loaded.warnings)
                                 device.Log().Send(LogLevel::Warning, log_category::kScene, warning);
                             if (!loaded.note.empty())
                                 device.Log().Send(LogLevel::Info, log_category::kScene, loaded.note);
                             ShowMessage(loaded.warnings.empty() ? "" : loaded.warnings.front());
                         });
    m_environment = {};
    if (!isShown && m_loadingMap.settings) m_missingMap = m_loadingMap;
    if (const std::optional<WantedMap> next = std::exchange(m_nextMap, std::nullopt))
        OpenEnvironment(next->file, next->settings);
}

void Workspace::GiveUpMaps() {
    m_isLoadStale = m_environment.valid();
    m_nextMap.reset();
    m_missingMap.reset();
}

EnvironmentSettings Workspace::SettingsFor(const WantedMap& map) const {
    return map.settings.value_or(
        EnvironmentSettings{.radiance = glm::vec3(1.0f), .rotation = gpu.Environment().rotation});
}

void Workspace::RemoveEnvironmentMap() {
    GiveUpMaps();
    gpu.RemoveEnvironmentMap();
    gpu.SetEnvironment(SceneEnvironment());
    m_environmentFile.clear();
    m_environmentHash.clear();
}

void Workspace::UseEnvironment(const std::filesystem::path& file, const EnvironmentSettings& settings) {
    m_defaultLight = settings.defaultLight;
    if (!file.empty() && file == m_environmentFile) {
        GiveUpMaps();
        return gpu.SetEnvironment(settings);
    }
    RemoveEnvironmentMap();  // until the map is there, the light is the scene's
    if (file.empty())
        gpu.SetEnvironment(settings);
    else
        OpenEnvironment(file, settings);
}

Workspace::Look Workspace::ShownLook() const {
    const passes::TonemapSettings& tonemap = view.Show().tonemap;
    return {tonemap.exposureEv, tonemap.tonemapOperator, m_whitePoint};
}

Workspace::Look Workspace::OwnLook() const {
    return m_lookOfScene == ShownLook() ? *m_lookBefore : ShownLook();
}

SceneView Workspace::ShownView() const {
    const Look look = ShownLook();
    const std::optional<uint32_t> followed = FollowedCamera();
    WantedMap map{m_environmentFile, gpu.Environment()};
    if (m_environment.valid() && !m_isLoadStale) map = m_loadingMap;
    if (m_nextMap) map = *m_nextMap;
    if (m_missingMap) map = *m_missingMap;
    const EnvironmentSettings environment = SettingsFor(map);
    return {.camera = followed ? CameraChoice(*this, *followed) : session::CameraText(camera.View()),
            .aperture = aperture,
            .focus = focus,
            .environment = map.file,
            .usesScene = environment.usesScene,
            .light = m_defaultLight,
            .radiance = environment.radiance,
            .rotation = glm::degrees(environment.rotation),
            .backdrop = session::BackdropText(backdrop),
            .hasGround = hasGround,
            .exposureEv = look.exposureEv,
            .whitePoint = look.whitePoint,
            .tonemap = look.tonemap};
}

void Workspace::Use(const SceneView& seen) {
    Try([&] { UseCamera(seen.camera); });
    aperture = seen.aperture;
    focus = seen.focus;
    Try([&] { backdrop = session::ParseBackdrop(seen.backdrop); });
    hasGround = seen.hasGround;
    m_lookBefore = OwnLook();
    viewport::ShowSettings show = view.Show();
    show.tonemap.exposureEv = seen.exposureEv;
    show.tonemap.tonemapOperator = seen.tonemap;
    view.SetShow(show);
    SetWhitePoint(seen.whitePoint);
    m_lookOfScene = ShownLook();
    UseEnvironment(seen.environment, {.radiance = seen.radiance,
                                      .rotation = glm::radians(seen.rotation),
                                      .usesScene = seen.usesScene,
                                      .defaultLight = seen.light});
}

void Workspace::UseLight(DefaultLight light) {
    m_defaultLight = light;
    if (m_environmentFile.empty()) gpu.SetEnvironment(SceneEnvironment());
}

ShownScene Workspace::Shown() const {
    const std::span<const scene::ClipState> clips = document.Clips();
    return {.input = {.file = document.File().filename().string(),
                      .variant = scene::VariantText(document.Scene(), document.Scene().variant),
                      .pointsAndLines = pointsAndLines,
                      .environmentFile = m_environmentFile.filename().string(),
                      .environmentHash = m_environmentHash},
            .camera = session::CameraText(camera.View()),
            .hasGround = hasGround,
            .at = clips.empty() ? std::nullopt : std::optional(clips.front().seconds),
            .clips = scene::ClipsText(document.Scene(), clips)};
}

std::optional<SceneLoader::Progress> Workspace::LoadProgress() const {
    if (loader.IsLoading()) return loader.Current();
    if (m_arriving) return SceneLoader::Progress{"copying to the device", m_arriving->upload->Fraction()};
    return std::nullopt;
}

std::optional<LoadedScene> Workspace::FinishLoading() {
    FinishLoadingEnvironment();
    if (std::optional<LoadResult> result = loader.Take()) {
        if (const LoadFailure* failure = std::get_if<LoadFailure>(&*result)) {
            ReportError(failure->message);
        } else {
            m_arriving = std::get<LoadedScene>(std::move(*result));
            if (!TryWithDocument(m_arriving->document,
                                 [&] { m_arriving->upload = gpu.Upload(std::move(m_arriving->scene)); }))
                m_arriving.reset();
        }
    }
    // Without frames nothing would be copied
    if (!m_arriving || !(m_arriving->upload->IsReady() || view.Size().IsEmpty())) return std::nullopt;
    return std::exchange(m_arriving, std::nullopt);
}

// Returns false if `run` throws an Error, which is then reported with the name of the document's file.
bool Workspace::TryWithDocument(const Document& of, const std::function<void()>& run) {
    try {
        run();
        return true;
    } catch (const Error& error) {
        ReportError(Text("{}: {}", of.File(), error.what()));
        return false;
    }
}

bool Workspace::Show(LoadedScene loaded) {
    if (!TryWithDocument(loaded.document, [&] { gpu.SetScene(*loaded.upload); })) return false;
    document = std::move(loaded.document);
    m_chosenCamera.reset();
    timeline = Timeline(document.Scene());
    AddRecentFile(document.File());
    hierarchy = Hierarchy(document.Children(), document.Roots());
    m_hierarchyFilter.clear();
    thumbnails.Clear();
    imageToReplace.reset();
    nodeToReveal.reset();
    nameDraft.reset();
    Select(std::nullopt);
    explained.Clear();
    bookmarks = {};
    m_isPickingFocus = false;
    m_focusRequest.reset();
    const scene::SceneData& scene = document.Scene();
    // A scene without a stored view keeps the environment map, and the look that the user has chosen
    SceneView seen = ShownView();
    const Look look = OwnLook();
    seen.exposureEv = look.exposureEv;
    seen.tonemap = look.tonemap;
    seen.whitePoint = look.whitePoint;
    seen.camera.clear();
    seen.aperture = seen.focus = 0.0f;
    if (seen.environment.empty()) {
        seen.usesScene = true;
        seen.radiance = glm::vec3(1.0f);
        seen.rotation = 0.0f;
    }
    if (loaded.view) seen = *loaded.view;
    if (loaded.changeView) loaded.changeView(seen);
    ShowMessage(scene.warnings.empty() ? "" : scene.warnings.front());
    if (!loaded.viewMessage.empty()) ReportError(loaded.viewMessage);
    Use(seen);
    return true;
}

void Workspace::Select(std::optional<uint32_t> node, std::optional<uint32_t> material) {
    SelectAll(node ? std::vector{*node} : std::vector<uint32_t>());
    selectedMaterial = material;
}

void Workspace::SelectAll(std::vector<uint32_t> nodes) {
    // A node that a click has met, or that a path names, may have been deleted since
    std::erase_if(nodes, [&](uint32_t node) { return !document.IsPresent(node); });
    selectedNodes = std::move(nodes);
    selectedNode = selectedNodes.empty() ? std::nullopt : std::optional(selectedNodes.back());
    m_rangeStart = selectedNode;
    selectedMaterial.reset();
    std::vector<uint32_t> outlined;
    for (const uint32_t top : document.Tops(selectedNodes))
        for (const uint32_t instance : document.InstancesUnder(top)) outlined.push_back(instance);
    view.SetOutlined(outlined);
}

bool Workspace::IsSelected(uint32_t node) const {
    return std::ranges::count(selectedNodes, node) > 0;
}

void Workspace::ToggleSelected(uint32_t node) {
    std::vector<uint32_t> nodes = selectedNodes;
    if (std::erase(nodes, node) == 0) nodes.push_back(node);
    SelectAll(std::move(nodes));
    m_rangeStart = node;
}

void Workspace::SelectRange(uint32_t node, bool isAdded) {
    const uint32_t start = m_rangeStart.value_or(node);
    std::vector<uint32_t> rows;
    std::optional<size_t> from, to;
    for (const Hierarchy::Row& row : hierarchy.Rows()) {
        if (row.node == start) from = rows.size();
        if (row.node == node) to = rows.size();
        rows.push_back(row.node);
    }
    if (!to) return;
    const uint32_t begin = from ? start : node;  // the row of the start may be gone
    if (!from) from = to;
    std::vector<uint32_t> nodes(rows.begin() + static_cast<std::ptrdiff_t>(std::min(*from, *to)),
                                rows.begin() + static_cast<std::ptrdiff_t>(std::max(*from, *to)) + 1);
    if (*to < *from) std::ranges::reverse(nodes);
    if (isAdded) {
        const std::set<uint32_t> added(nodes.begin(), nodes.end());
        std::vector<uint32_t> kept;
        std::ranges::copy_if(selectedNodes, std::back_inserter(kept),
                             [&](uint32_t other) { return !added.contains(other); });
        nodes.insert(nodes.begin(), kept.begin(), kept.end());
    }
    SelectAll(std::move(nodes));
    m_rangeStart = begin;
}

void Workspace::FilterHierarchy(std::string part) {
    m_hierarchyFilter = std::move(part);
    if (m_hierarchyFilter.empty()) return hierarchy.EndFilter();
    std::vector<bool> isMatch(document.Scene().nodes.size(), false);
    for (const uint32_t node : document.Scene().nodeOrder)
        isMatch[node] = HasPart(document.NameOf(node), m_hierarchyFilter);
    hierarchy.SetFilter(isMatch);
}

std::optional<uint32_t> Workspace::FollowedCamera() const {
    if (!m_chosenCamera || !(m_chosenCamera->view == camera.View())) return std::nullopt;
    return m_chosenCamera->camera;
}

std::optional<uint32_t> Workspace::FirstCamera() const {
    const std::vector<scene::Camera>& cameras = document.Scene().cameras;
    for (uint32_t i = 0; i < cameras.size(); ++i)
        if (document.IsPresent(cameras[i].node)) return i;
    return std::nullopt;
}

float Workspace::Aspect() const {
    const Extent2D size = view.Size();
    return size.IsEmpty() ? 1.0f : static_cast<float>(size.width) / static_cast<float>(size.height);
}

void Workspace::SetCameraView(const scene::CameraView& place) {
    const scene::Bounds& bounds = document.Scene().bounds;
    const float distance =
        bounds.IsEmpty() ? 1.0f : glm::dot(bounds.Center() - glm::vec3(place.eye), place.forward);
    camera.Set(place, distance > 0.0f ? distance : std::max(bounds.Radius(), 0.01f));
    m_chosenCamera.reset();
}

void Workspace::UseCamera(std::optional<uint32_t> index) {
    const scene::SceneData& scene = document.Scene();
    SetCameraView(index ? scene::ViewOf(scene.cameras.at(*index), Aspect())
                        : scene::ViewOfBounds(scene.bounds, Aspect()));
    if (index) m_chosenCamera = {*index, camera.View()};
}

void Workspace::UseCamera(const std::string& choice) {
    const scene::SceneData& scene = document.Scene();
    if (const std::optional<uint32_t> index = scene::FindCamera(scene, choice))
        UseCamera(index);
    else if (choice.empty())
        UseCamera(FirstCamera());
    else
        SetCameraView(scene::ChooseView(scene, choice, Aspect()));
}

void Workspace::Animate(double seconds) {
    timeline.Advance(seconds);
    try {
        if (!document.ShowPose(timeline.Shown(), gpu)) return;
        m_refusedPose.clear();
    } catch (const std::exception& error) {
        timeline.Pause();
        ReportErrorOnce(error.what(), m_refusedPose);
        return;
    }
    if (const std::optional<uint32_t> followed = FollowedCamera()) UseCamera(followed);
}

scene::Bounds Workspace::SelectionBounds() const {
    scene::Bounds bounds;
    for (const uint32_t node : document.Tops(selectedNodes)) {
        const scene::Bounds own = document.BoundsOf(node);
        if (own.IsEmpty())
            bounds.Extend(document.WorldTransform(node)[3]);  // a light, for example
        else
            bounds.Extend(own);
    }
    return bounds;
}

void Workspace::FrameSelection() {
    const scene::Bounds& all = document.Scene().bounds;
    if (!selectedNode) return camera.Frame(all);
    scene::Bounds bounds = SelectionBounds();
    if (bounds.min == bounds.max) {
        const glm::vec3 around(all.IsEmpty() ? 1.0f : std::max(0.1f * all.Radius(), 1e-3f));
        bounds = {bounds.min - around, bounds.max + around};
    }
    camera.Frame(bounds);
}

}  // namespace raygraph::editor
