// Rendering offline, and the pictures.
#include <chrono>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "c/call.h"
#include "c/handles.h"
#include "editor/session/denoise.h"
#include "editor/session/file/merge.h"
#include "editor/session/settings/parse.h"

using raygraph::ErrorKind;
using raygraph::MakeError;
using raygraph::c::Call;
using raygraph::c::Guarded;
namespace session = raygraph::session;

namespace raygraph::c {

namespace {

constexpr uint32_t kDefaultSamples = 64;

RgProgress ToProgress(const session::ProgressState& state) {
    RgProgress progress{};
    progress.struct_size = sizeof(RgProgress);
    progress.samples = state.samplesDone;
    progress.samples_wanted = state.samplesWanted.value_or(0);
    progress.samples_per_second = state.samplesPerSecond;
    progress.relative_error = state.relativeError.value_or(-1.0);
    progress.seconds_left = state.secondsLeft.value_or(-1.0);
    return progress;
}

RgPicture* Keep(session::FinishedPicture&& picture) {
    auto kept = std::make_unique<RgPicture>();
    kept->picture = std::move(picture);
    kept->channels = session::ChannelsOf(kept->picture.render);
    return kept.release();
}

RgChannel ChannelOf(const RgPicture& of, const session::PictureChannel& channel) {
    RgChannel made{};
    made.number = channel.isInteger ? RG_UINT32 : RG_FLOAT32;
    made.width = of.picture.render.size.width;
    made.height = of.picture.render.size.height;
    made.channels = channel.channels;
    made.pixel_stride = channel.stride * static_cast<uint32_t>(sizeof(float));
    made.data = channel.data;
    return made;
}

// Returns the display picture, which is made only once: hosts view its memory.
const image::Image8& DisplayOf(const Call& call, RgPicture& of, const RgDevice* device) {
    std::optional<image::Image8>& display = of.picture.display;
    if (!display) {
        if (device == nullptr) call.Refuse("device is NULL, and the picture was read or merged");
        display = session::ShowRender(*device->device, of.picture.render);
    }
    return *display;
}

}  // namespace

}  // namespace raygraph::c

RgResult rg_render(RgDevice* device, RgScene* scene, const RgSettings* settings, RgProgressCallback progress,
                   void* user, RgPicture** picture) {
    return Guarded("rg_render", [&](const Call& call) {
        const auto on = call.Required(device, "device").device;
        session::EditedScene& of = call.Required(scene, "scene").scene;
        call.Required(picture, "picture");
        raygraph::c::RenderOptions options = raygraph::c::OptionsOf(settings);
        session::PictureRequest& request = options.request;
        if (!request.samples && !request.seconds && !request.relativeError)
            request.samples = raygraph::c::kDefaultSamples;
        session::PlannedPicture planned = session::PlanPicture(of, std::move(options.settings), request);
        const auto tell = [&](const session::ProgressState& state) {
            const RgProgress now = raygraph::c::ToProgress(state);
            return progress(user, &now);
        };
        session::ProgressState state{.samplesWanted = planned.rule.samples};
        auto told = std::chrono::steady_clock::now();
        const auto isStopRequested = [&] {
            constexpr auto kInterval = std::chrono::milliseconds(100);
            const auto now = std::chrono::steady_clock::now();
            if (progress == nullptr || state.samplesDone > 0 || now - told < kInterval) return false;
            told = now;
            return !tell(state);
        };
        std::function<bool(const session::ProgressState&)> goesOn;
        if (progress != nullptr)
            goesOn = [&](const session::ProgressState& after) { return tell(state = after); };
        std::optional<session::FinishedPicture> made =
            session::Render({on}, std::move(planned), isStopRequested, goesOn);
        if (!made) throw raygraph::c::Stopped{};
        *picture = raygraph::c::Keep(std::move(*made));
    });
}

RgResult rg_merge(const RgPicture* const* pictures, uint32_t count, RgPicture** merged) {
    return Guarded("rg_merge", [&](const Call& call) {
        call.Required(merged, "merged");
        session::Merger merger;
        for (uint32_t i = 0; i < count; ++i) {
            const std::string name = raygraph::Text("pictures[{}]", i);
            const RgPicture* part = (&call.Required(pictures, "pictures"))[i];
            merger.Add({name, call.Required(part, name.c_str()).picture.render});
        }
        *merged = raygraph::c::Keep({.render = merger.Take(), .display = {}});
    });
}

RgResult rg_picture_read(const char* path, RgPicture** picture) {
    return Guarded("rg_picture_read", [&](const Call& call) {
        call.RequiredText(path, "path");
        call.Required(picture, "picture") =
            raygraph::c::Keep({.render = session::ReadRenderFile(path), .display = {}});
    });
}

void rg_picture_destroy(RgPicture* picture) {
    delete picture;
}

RgResult rg_picture_get_info(const RgPicture* picture, RgPictureInfo* info) {
    return Guarded("rg_picture_get_info", [&](const Call& call) {
        const session::FinishedPicture& of = call.Required(picture, "picture").picture;
        RgPictureInfo made{};
        made.width = of.render.size.width;
        made.height = of.render.size.height;
        made.was_stopped = of.wasStopped ? 1 : 0;
        made.samples = session::SampleCount(of.render.samples);
        made.relative_error = session::RelativeErrorOf(of.render).value_or(-1.0);
        made.seconds = of.seconds;
        call.Write(info, "info", made);
    });
}

RgResult rg_picture_get_channel(const RgPicture* picture, const char* name, RgChannel* channel) {
    return Guarded("rg_picture_get_channel", [&](const Call& call) {
        const RgPicture& of = call.Required(picture, "picture");
        call.RequiredText(name, "name");
        std::string names;
        for (const session::PictureChannel& each : of.channels) {
            if (each.name == name) {
                call.Write(channel, "channel", raygraph::c::ChannelOf(of, each));
                return;
            }
            names += (names.empty() ? "" : ", ") + each.name;
        }
        call.Refuse(raygraph::Text("the picture has no {}; it has {}", raygraph::Quoted(name), names));
    });
}

const char* rg_picture_channel_name(const RgPicture* picture, uint32_t index) {
    return picture != nullptr && index < picture->channels.size() ? picture->channels[index].name.c_str()
                                                                  : nullptr;
}

RgResult rg_picture_denoise(RgPicture* picture, RgDevice* device, const char* denoiser) {
    return Guarded("rg_picture_denoise", [&](const Call& call) {
        RgPicture& of = call.Required(picture, "picture");
        const auto on = call.Required(device, "device").device;
        const auto by = denoiser == nullptr ? session::FileDenoiser::Network
                                            : session::ParseChoice<session::FileDenoiser>(denoiser);
        of.picture.display = session::Denoise(*on, of.picture.render, {}, by);
        of.channels = session::ChannelsOf(of.picture.render);
    });
}

RgResult rg_picture_display(RgPicture* picture, RgDevice* device, RgChannel* channel) {
    return Guarded("rg_picture_display", [&](const Call& call) {
        RgPicture& of = call.Required(picture, "picture");
        const raygraph::image::Image8& shown = raygraph::c::DisplayOf(call, of, device);
        RgChannel made{};
        made.number = RG_UINT8;
        made.width = shown.width;
        made.height = shown.height;
        made.channels = made.pixel_stride = 4;
        made.data = shown.rgba.data();
        call.Write(channel, "channel", made);
    });
}

RgResult rg_picture_save(RgPicture* picture, RgDevice* device, const char* path) {
    return Guarded("rg_picture_save", [&](const Call& call) {
        RgPicture& of = call.Required(picture, "picture");
        session::SavePicture(
            call.RequiredText(path, "path"), of.picture.render,
            [&]() -> const raygraph::image::Image8& { return raygraph::c::DisplayOf(call, of, device); }, {});
    });
}
