#include "editor/cli/verify_suite.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "base/files.h"
#include "base/text.h"
#include "editor/session/settings/as_input.h"
#include "editor/session/settings/setting_table.h"

namespace raygraph::cli {

namespace {

using SuiteJson = nlohmann::json;

// Reads the keys of cases.
class SuiteReader {
  public:
    explicit SuiteReader(const std::filesystem::path& path) : m_path(path), m_folder(path.parent_path()) {}

    std::vector<VerifyCase> Read() const {
        const std::vector<std::byte> bytes = AsInput([&] { return ReadFile(m_path, kMostBytes); });
        const auto* const first = reinterpret_cast<const char*>(bytes.data());
        const SuiteJson json = Parse(first, first + bytes.size());
        if (!json.is_object() || !json.contains("cases") || !json["cases"].is_array())
            Fail("cases", "there is no list of cases");
        for (const auto& [key, value] : json.items())
            if (key != "cases" && key != "defaults") Fail(key, "there is no such key");
        VerifyCase defaults;
        defaults.accepted = m_folder / "accepted";
        defaults.folder = m_folder;
        if (json.contains("defaults")) Take(defaults, "defaults", json["defaults"]);
        std::vector<VerifyCase> cases;
        for (const SuiteJson& each : json["cases"]) {
            const std::string where = Text("cases[{}]", cases.size());
            VerifyCase one = defaults;
            Take(one, where, each);
            if (one.scene.empty()) Fail(where + ".scene", "it is missing");
            if (one.pictures.empty()) Fail(where + ".pictures", "they are missing");
            if (one.name.empty()) one.name = one.scene.stem().string();
            cases.push_back(std::move(one));
        }
        if (cases.empty()) Fail("cases", "the list is empty");
        return cases;
    }

  private:
    static constexpr uint64_t kMostBytes = uint64_t{1} << 24;

    SuiteJson Parse(const char* first, const char* last) const {
        try {
            return SuiteJson::parse(first, last);
        } catch (const SuiteJson::parse_error& error) {
            const size_t before = std::min(error.byte, static_cast<size_t>(last - first));
            Fail(Text("line {}", 1 + std::count(first, first + before, '\n')), "it is no JSON");
        }
    }
    // Throws as `get` does for what is no count.
    static uint32_t Count(const SuiteJson& value, uint32_t least) {
        if (value.is_number_integer() && (value < least || value > (uint32_t{1} << 24)))
            throw MakeError(ErrorKind::Usage, "it is not from {} to {}", least, uint32_t{1} << 24);
        if (value.is_number() && !value.is_number_integer())
            throw Error(ErrorKind::Usage, "it is no whole number");
        return value.get<uint32_t>();
    }

    [[noreturn]] void Fail(const std::string& where, std::string_view why) const {
        throw MakeError(ErrorKind::BadInput, "{}: {}{}{}", m_path, Printable(where),
                        where.empty() ? "" : ": ", Printable(why, 1024));
    }
    // Turns the errors of a value into one that names its key.
    template <typename Read>
    auto At(const std::string& where, Read&& read) const {
        try {
            return read();
        } catch (const SuiteJson::exception&) {
            Fail(where, "its value has the wrong type");
        } catch (const Error& error) {
            Fail(where, error.what());
        }
    }

    void Take(VerifyCase& into, const std::string& where, const SuiteJson& json) const {
        if (!json.is_object()) Fail(where, "it is no object");
        for (const auto& [name, value] : json.items()) {
            const std::string& key = name;
            const SuiteJson& given = value;
            At(where + "." + key, [&] { TakeKey(into, key, given); });
        }
    }
    void TakeKey(VerifyCase& into, const std::string& key, const SuiteJson& value) const {
        const auto text = [&] { return value.get<std::string>(); };
        const auto path = [&] { return m_folder / text(); };
        if (key == "name") {
            into.name = text();
        } else if (key == "scene") {
            into.scene = path();
        } else if (key == "pictures") {
            into.pictures.clear();
            for (const SuiteJson& each : value) into.pictures.push_back(m_folder / each.get<std::string>());
        } else if (key == "env") {
            into.environment = path();
        } else if (key == "root") {
            into.root = path();
        } else if (key == "mask") {
            into.mask = path();
        } else if (key == "accepted") {
            into.accepted = path();
        } else if (key == "transfer") {
            const float exposureEv = into.transfer.exposureEv;
            into.transfer = ParseTransfer(text());
            into.transfer.exposureEv = exposureEv;
        } else if (key == "exposure") {
            into.transfer.exposureEv = value.get<float>();
        } else if (key == "spp") {
            into.maxSamples = Count(value, 2);
        } else if (key == "picture_spp") {
            into.pictureSamples = Count(value, 0);
        } else if (key == "against") {
            TakeSetting(into, "view", text());
        } else if (key == "regions") {
            for (const SuiteJson& each : value) into.regions.push_back(ParseRegion(each.get<std::string>()));
        } else if (key == "settings") {
            for (const auto& [name, setting] : value.items())
                TakeSetting(into, name, setting.is_string() ? setting.get<std::string>() : setting.dump());
        } else if (key == "tolerance") {
            for (const auto& [name, number] : value.items()) TakeTolerance(into.tolerance, name, number);
        } else {
            throw Error(ErrorKind::Usage, "there is no such key");
        }
    }
    static void TakeSetting(VerifyCase& into, const std::string& name, const std::string& text) {
        if (!IsSetting(name)) throw MakeError(ErrorKind::Usage, "there is no setting {}", Quoted(name));
        into.given[name] = text;
        SettingsFrom({{name, text}});  // rejects malformed texts
    }
    static void TakeTolerance(Tolerance& into, const std::string& name, const SuiteJson& number) {
        constexpr std::pair<const char*, double Tolerance::*> kFields[] = {
            {"relative", &Tolerance::relative}, {"tiles", &Tolerance::tiles}, {"pixels", &Tolerance::pixels},
            {"energy", &Tolerance::energy},     {"parts", &Tolerance::parts}, {"flip", &Tolerance::flip},
            {"ssim", &Tolerance::ssim}};
        for (const auto& [field, member] : kFields) {
            if (name != field) continue;
            into.*member = number.get<double>();
            if (!(into.*member >= 0.0)) throw MakeError(ErrorKind::Usage, "{} is below 0", name);
            return;
        }
        throw MakeError(ErrorKind::Usage, "there is no tolerance {}", Quoted(name));
    }

    const std::filesystem::path& m_path;
    std::filesystem::path m_folder;
};

}  // namespace

std::filesystem::path AcceptedFile(const VerifyCase& one, const std::filesystem::path& picture) {
    if (one.accepted.empty()) return {};
    std::filesystem::path relative = picture.lexically_normal();
    if (!one.folder.empty()) relative = relative.lexically_relative(one.folder.lexically_normal());
    if (relative.empty() || relative.is_absolute()) relative = picture.filename();
    if (relative.extension() == ".exr") relative.replace_extension();
    std::string name = one.name.empty() ? std::string() : one.name + ".";
    for (const char c : relative.generic_string()) name += c == '/' ? '.' : c;
    return one.accepted / (name + ".exr");
}

void RequireDistinctAccepted(const std::vector<VerifyCase>& cases) {
    std::map<std::filesystem::path, std::filesystem::path> taken;
    for (const VerifyCase& one : cases)
        for (const std::filesystem::path& picture : one.pictures) {
            const std::filesystem::path file = AcceptedFile(one, picture);
            if (file.empty()) continue;
            const auto [at, isNew] = taken.try_emplace(file, picture);
            if (!isNew)
                throw MakeError(ErrorKind::Usage,
                                "{} and {} have one accepted difference, {}; give their cases a name",
                                at->second, picture, file);
        }
}

std::vector<VerifyCase> ReadSuite(const std::filesystem::path& path) {
    return SuiteReader(path).Read();
}

}  // namespace raygraph::cli
