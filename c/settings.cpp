// Settings by name: those of the linear picture (editor/session/settings/setting_table.h), and what else a
// render is asked for.
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "c/call.h"
#include "c/handles.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/setting_table.h"

using raygraph::c::Call;
using raygraph::c::Guarded;
namespace session = raygraph::session;

namespace raygraph::c {

namespace {

// A setting that is none of the linear picture: `read` takes a text, or throws Error{Usage} that quotes it.
struct RequestSetting {
    const char* name;
    const char* byDefault;
    void (*read)(session::PictureRequest& request, const std::string& text);
};
constexpr std::array kRequestSettings{
    RequestSetting{"spp", "",
                   [](session::PictureRequest& request, const std::string& text) {
                       request.samples = session::ParseCount(text, 1);
                   }},
    RequestSetting{"time", "",
                   [](session::PictureRequest& request, const std::string& text) {
                       request.seconds = session::ParseNumber(text, 0.0);
                   }},
    RequestSetting{"error", "",
                   [](session::PictureRequest& request, const std::string& text) {
                       request.relativeError = session::ParseNumber(text, 0.0);
                   }},
    RequestSetting{"sample-offset", "0",
                   [](session::PictureRequest& request, const std::string& text) {
                       request.firstSample = session::ParseCount(text);
                   }},
    RequestSetting{"aov", "",
                   [](session::PictureRequest& request, const std::string& text) {
                       for (const std::string_view name : session::ParseList(text)) {
                           session::ParseChoice<session::Aov>(name);
                           request.aovs.emplace_back(name);
                       }
                   }},
    RequestSetting{"denoise", "off",
                   [](session::PictureRequest& request, const std::string& text) {
                       if (text == "off") return;
                       if (text != "on") session::ParseChoice<passes::Denoiser>(text);
                       request.denoiser = text == "on" ? Name(passes::Denoiser::Network) : text;
                   }},
    RequestSetting{"exposure", "0",
                   [](session::PictureRequest& request, const std::string& text) {
                       request.exposureEv = static_cast<float>(session::ParseNumber(text, -100.0, 100.0));
                   }},
    RequestSetting{"tonemap", "",
                   [](session::PictureRequest& request, const std::string& text) {
                       if (text != "raw") session::ParseChoice<TonemapOperator>(text);
                       request.tonemap = text;
                   }},
    RequestSetting{"white-point", "",
                   [](session::PictureRequest& request, const std::string& text) {
                       if (text != "auto")
                           session::ParseNumber(text, passes::kMinWhitePoint, passes::kMaxWhitePoint);
                       request.whitePoint = text;
                   }},
};

const RequestSetting* FindRequestSetting(std::string_view name) {
    const auto found = std::ranges::find(kRequestSettings, name,
                                         [](const RequestSetting& s) { return std::string_view(s.name); });
    return found == kRequestSettings.end() ? nullptr : &*found;
}

// Settings that a scene is loaded with are not set.
constexpr std::array<std::string_view, 4> kLoaded{"scene", "variant", "points", "lines"};

const std::vector<const char*>& SettingNames() {
    static const std::vector<const char*> names = [] {
        std::vector<const char*> list;
        for (const session::PictureSetting& setting : session::PictureSettingTable())
            if (std::ranges::find(kLoaded, setting.name) == kLoaded.end()) list.push_back(setting.name);
        for (const RequestSetting& setting : kRequestSettings) list.push_back(setting.name);
        return list;
    }();
    return names;
}

void RequireSetting(const Call& call, const char* name) {
    for (const char* known : SettingNames())
        if (std::string_view(known) == name) return;
    std::string list;
    for (const char* known : SettingNames()) list += std::string(list.empty() ? "" : ", ") + known;
    call.Refuse(Text("{} is no setting; there are {}", Quoted(name), list));
}

// Takes texts one by one, so that the line of a failure begins with the setting's name.
void ReadInto(RenderOptions& options, const std::string& name, const std::string& text) {
    const RequestSetting* of = FindRequestSetting(name);
    if (of == nullptr) {
        options.settings[name] = text;
        return;
    }
    try {
        of->read(options.request, text);
    } catch (const Error& error) {
        throw session::SettingError(error.Kind(), Text("{}: {}", name, error.what()));
    }
}

}  // namespace

RenderOptions OptionsOf(const RgSettings* settings) {
    RenderOptions options;
    if (settings != nullptr)
        for (const auto& [name, text] : settings->texts) ReadInto(options, name, text);
    return options;
}

}  // namespace raygraph::c

RgResult rg_settings_create(RgSettings** settings) {
    return Guarded("rg_settings_create",
                   [&](const Call& call) { call.Required(settings, "settings") = new RgSettings; });
}

void rg_settings_destroy(RgSettings* settings) {
    delete settings;
}

RgResult rg_settings_set(RgSettings* settings, const char* name, const char* text) {
    return Guarded("rg_settings_set", [&](const Call& call) {
        RgSettings& to = call.Required(settings, "settings");
        raygraph::c::RequireSetting(call, call.RequiredText(name, "name"));
        session::SettingTexts texts = to.texts;
        texts.erase(name);
        if (text != nullptr) texts[name] = text;
        RgSettings edited{.texts = std::move(texts), .answers = {}};
        // Settings are read together, since a crop is within a size
        std::ignore = session::SettingsFrom(raygraph::c::OptionsOf(&edited).settings);
        to = std::move(edited);
    });
}

RgResult rg_settings_get(const RgSettings* settings, const char* name, const char** text) {
    return Guarded("rg_settings_get", [&](const Call& call) {
        const RgSettings& of = call.Required(settings, "settings");
        raygraph::c::RequireSetting(call, call.RequiredText(name, "name"));
        call.Required(text, "text");
        const auto given = of.texts.find(name);
        std::string& answer = of.answers[name];
        if (const auto* request = raygraph::c::FindRequestSetting(name))
            answer = given != of.texts.end() ? given->second : request->byDefault;
        else
            answer = session::Texts(session::SettingsFrom(raygraph::c::OptionsOf(&of).settings)).at(name);
        *text = answer.c_str();
    });
}

const char* rg_setting_name(uint32_t index) {
    const std::vector<const char*>& names = raygraph::c::SettingNames();
    return index < names.size() ? names[index] : nullptr;
}
