#include "editor/app/script.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>

#include "base/files.h"
#include "base/overloaded.h"
#include "base/printable.h"
#include "base/text.h"
#include "editor/session/settings/parse.h"
#include "renderer/scene/gltf/still_scene.h"
#include "renderer/scene/model/variants.h"

namespace raygraph::editor {

namespace {

constexpr int kDragSteps = 8;
constexpr std::string_view kNoVariant = "none";
constexpr std::chrono::seconds kMaxWait{300};
constexpr uint64_t kMaxScriptBytes = 1 << 20;

std::string TextOf(const std::filesystem::path& file) {
    const std::vector<std::byte> bytes = ReadFile(file, kMaxScriptBytes);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Returns whether the view has `wanted` samples, or as many as it can have.
bool HasSamples(const viewport::Viewport& view, uint32_t wanted) {
    const viewport::ViewportProgress progress = view.Progress();
    const viewport::ShowSettings& shown = view.Show();
    return (!ShowsPathTraced(shown.view) || progress.pathTracedSamples >= wanted) &&
           (!ShowsRaster(shown) ||
            (progress.rasterSamples > 0 &&
             (progress.rasterSamples >= wanted || progress.rasterSamples == progress.rasterSamplesWanted)));
}

// Sets a number that says how the picture looks.
void Look(const SetLook& command, Workspace& work) {
    using Of = SetLook::Of;
    scene::CameraView camera = work.camera.View();
    viewport::ShowSettings show = work.view.Show();
    switch (command.of) {
        case Of::FieldOfView:
            camera.yFov = glm::radians(command.value);
            return work.camera.Set(camera, work.camera.Distance());
        case Of::Aperture:
            work.aperture = command.value;
            return;
        case Of::Focus:
            work.focus = command.value;
            return;
        case Of::Exposure:
            show.tonemap.exposureEv = command.value;
            return work.view.SetShow(show);
        case Of::WhitePoint:
            return work.SetWhitePoint(static_cast<int>(command.value));
    }
}

}  // namespace

Script::Script(const std::filesystem::path& file)
    : m_file(file), m_lines(ParseScript(TextOf(file), file.string())) {
    m_input.extent = {1280, 720};
}

void Script::Fail(const ScriptLine& line, const std::string& why) const {
    ThrowLineError(m_file.string(), line.number, line.text, why);
}

void Script::Frame(Editor& editor, Screen& screen) {
    editor.Frame(m_input, screen);
    if (!editor.FrameError().empty()) throw Error(ErrorKind::BadInput, editor.FrameError());
    m_input.pressed.clear();
    m_input.text.clear();
    m_input.dropped.clear();
    m_input.isClosing = false;
    m_input.wheel = 0.0f;
}

void Script::PlayAnimation(double seconds, Editor& editor, Screen& screen) {
    const float step = m_input.seconds;
    editor.Work().timeline.Play();
    while (seconds > 0.0) {
        m_input.seconds = static_cast<float>(std::min(seconds, double{step}));
        seconds -= double{m_input.seconds};
        Frame(editor, screen);
    }
    m_input.seconds = step;
    editor.Work().timeline.Pause();
}

void Script::Play(Editor& editor, Screen& screen) {
    Frame(editor, screen);
    for (const ScriptLine& line : m_lines) {
        try {
            Do(line, editor, screen);
        } catch (const Error& error) {
            if (error.Kind() != ErrorKind::Usage) throw;
            Fail(line, error.what());
        }
    }
    editor.StoreSettings();
}

void Script::Do(const ScriptLine& line, Editor& editor, Screen& screen) {
    const auto frame = [&] { Frame(editor, screen); };
    const auto until = [&](const char* what, auto&& isDone) {
        const auto start = std::chrono::steady_clock::now();
        while (std::chrono::steady_clock::now() - start < kMaxWait) {
            frame();
            if (isDone()) return;
        }
        Fail(line, Text("still not {} after {} s; {}", what, kMaxWait.count(), editor.Work().message));
    };
    const auto orFail = [&](auto&& action) {
        try {
            action();
        } catch (const Error& error) {
            Fail(line, error.what());
        }
    };
    const auto requireAnimations = [&] {
        if (editor.Work().timeline.IsEmpty()) Fail(line, "the scene has no animations");
    };
    std::visit(
        Overloaded{[&](const SetSize& command) {
                       m_input.extent = command.extent;
                       frame();
                   },
                   [&](const SetScale& command) {
                       m_input.scale = command.scale;
                       frame();
                   },
                   [&](const DropFile& command) {
                       m_input.dropped.push_back(command.file);
                       frame();
                   },
                   [&](const CloseWindow&) {
                       m_input.isClosing = true;
                       frame();
                       frame();  // draws the question, if there is one
                   },
                   [&](const PressKey& command) {
                       m_input.isControl = command.isControl;
                       m_input.isShift = command.isShift;
                       m_input.pressed.push_back(command.key);
                       m_input.keys[static_cast<size_t>(command.key)] = true;
                       frame();
                       m_input.keys[static_cast<size_t>(command.key)] = false;
                       m_input.isControl = m_input.isShift = false;
                       frame();
                   },
                   [&](const MoveMouse& command) {
                       m_input.mouse = command.place;
                       frame();
                   },
                   [&](const HoldButton& command) {
                       bool& isHeld = m_input.buttons[static_cast<size_t>(command.button)];
                       m_input.isControl = command.isControl;
                       m_input.isShift = command.isShift;
                       if (command.isDown) {
                           isHeld = true;
                           frame();
                       }
                       for (int i = 0; i < kDragSteps && command.isDragged; ++i) {
                           m_input.mouse += command.way / float(kDragSteps);
                           frame();
                       }
                       if (command.isUp) {
                           isHeld = false;
                           frame();
                       }
                       m_input.isControl = m_input.isShift = false;
                   },
                   [&](const ScrollWheel& command) {
                       m_input.wheel = command.notches;
                       frame();
                   },
                   [&](const TypeText& command) {
                       m_input.text = command.text;
                       frame();
                   },
                   [&](const SelectNodes& command) {
                       Workspace& work = editor.Work();
                       std::vector<uint32_t> nodes;
                       for (const std::string& name : command.names) {
                           const std::vector<uint32_t>& all = work.document.Scene().nodeOrder;
                           const auto node = std::ranges::find(
                               all, name, [&](uint32_t i) { return work.document.NameOf(i); });
                           if (node == all.end()) Fail(line, Text("there is no node {}", Quoted(name)));
                           nodes.push_back(*node);
                       }
                       work.SelectAll(std::move(nodes));
                       work.nodeToReveal = work.selectedNode;
                       frame();
                   },
                   [&](const AdvanceFrames& command) {
                       for (uint32_t i = 0; i < command.count; ++i) frame();
                   },
                   [&](const WaitUntilDone&) { until("done", [&] { return !editor.IsBusy(); }); },
                   [&](const WaitForSamples& command) {
                       until("there", [&] { return HasSamples(editor.Work().view, command.count); });
                   },
                   [&](const SaveShown& command) {
                       const uint64_t before = editor.SavedCount();
                       if (command.isWindow)
                           editor.SaveWindow(command.file);
                       else
                           editor.SavePicture(command.file);
                       // Renders may go on meanwhile
                       until("saved", [&] { return editor.SavedCount() > before || !editor.IsBusy(); });
                       // The existence of the file is no proof: it may be an old one
                       if (editor.SavedCount() == before) Fail(line, editor.Work().message);
                   },
                   [&](const FillRenderDialog& command) {
                       editor.OpenRenderDialog().Fill(command.size, command.samples, command.file);
                       frame();
                       frame();  // its field has the keys now
                   },
                   [&](const SetLook& command) {
                       Look(command, editor.Work());
                       frame();
                   },
                   [&](const SetBudget& command) { editor.Work().frameMs = command.frameMs; },
                   [&](const UseConfigFolder& command) {
                       editor.SetConfigFolder(command.folder);
                       frame();
                   },
                   [&](const SaveSceneFile& command) {
                       if (!editor.SaveScene(command.file)) Fail(line, editor.Work().message);
                       frame();
                   },
                   [&](const ShowView& command) {
                       editor.Work().view.SetView(command.view);
                       frame();
                   },
                   [&](const CompareWith& command) {
                       viewport::ShowSettings show = editor.Work().view.Show();
                       show.compared = command.compared;
                       editor.Work().view.SetShow(show);
                       frame();
                   },
                   [&](const SetBackdrop& command) { editor.Work().backdrop = command.backdrop; },
                   [&](const SetGround& command) { editor.Work().hasGround = command.isOn; },
                   [&](const SetDenoised& command) {
                       viewport::ShowSettings show = editor.Work().view.Show();
                       show.isDenoised = command.isOn;
                       editor.Work().view.SetShow(show);
                       frame();
                   },
                   [&](const ShowVariant& command) {
                       Workspace& work = editor.Work();
                       const scene::SceneData& scene = work.document.Scene();
                       const std::string choice = command.choice == kNoVariant ? "" : command.choice;
                       orFail([&] { work.ShowVariant(FindVariant(scene, choice)); });
                       frame();
                   },
                   [&](const PlayFor& command) {
                       requireAnimations();
                       PlayAnimation(command.seconds, editor, screen);
                   },
                   [&](const ShowTime& command) {
                       requireAnimations();
                       editor.Work().timeline.Seek(command.seconds);
                       frame();
                   },
                   [&](const StopPlaying&) {
                       editor.Work().timeline.Stop();
                       frame();
                   },
                   [&](const ChooseClips& command) {
                       Workspace& work = editor.Work();
                       const scene::SceneData& scene = work.document.Scene();
                       orFail([&] {
                           const std::vector<scene::ClipState> clips = FindClips(scene, command.list, 0.0);
                           RequirePlayable(scene, clips);
                           work.timeline.Choose(clips);
                       });
                       frame();
                   },
                   [&](const SetBaseColor& command) {
                       Workspace& work = editor.Work();
                       if (!work.selectedMaterial) Fail(line, "no material is selected");
                       scene::Material material = work.document.Scene().materials[*work.selectedMaterial];
                       material.baseColorFactor = glm::vec4(command.color, 1.0f);
                       work.Apply(MaterialEdit{*work.selectedMaterial, material});
                       work.document.Settle();
                       frame();
                   },
                   [&](const Expectation& expected) { Expect(line, expected, editor); }},
        line.command);
}

void Script::Expect(const ScriptLine& line, const Expectation& expected, Editor& editor) const {
    using Of = Expectation::Of;
    Workspace& work = editor.Work();
    const auto require = [&](bool holds, const std::string& actual) {
        if (!holds) Fail(line, Text("it is '{}'", actual));
    };
    const auto requireAnswer = [&](bool actual) {
        require(actual == (expected.number != 0), actual ? "yes" : "no");
    };
    const uint32_t samples = work.view.Progress().pathTracedSamples;
    const size_t edits = work.document.EditCount();
    const std::string view = Name(work.view.Show().view);
    const size_t nodes = work.document.Scene().nodeOrder.size();
    std::string selected;
    for (const uint32_t node : work.selectedNodes)
        selected += (selected.empty() ? "" : ", ") + work.document.NameOf(node);
    if (selected.empty()) selected = "nothing";
    const Timeline& timeline = work.timeline;
    const std::string time = timeline.IsAtRest() ? "rest" : Text("{:.3f}", timeline.Seconds());
    const uint32_t variant = work.document.Scene().variant;
    const std::string shown = variant == scene::kNone ? std::string(kNoVariant)
                                                      : scene::VariantText(work.document.Scene(), variant);
    switch (expected.of) {
        case Of::Selected:
            return require(selected == expected.text, selected);
        case Of::View:
            return require(view == Name(expected.view), view);
        case Of::Variant:
            return require(shown == expected.text, shown);
        case Of::Message:
            return require(work.message.find(expected.text) != std::string::npos, work.message);
        case Of::Edits:
            return require(edits == expected.number, std::to_string(edits));
        case Of::Nodes:
            return require(nodes == expected.number, std::to_string(nodes));
        case Of::Time:
            return require(time == expected.text, time);
        case Of::Playing:
            return requireAnswer(timeline.IsPlaying());
        case Of::Asking:
            return requireAnswer(editor.IsPrompting());
        case Of::Leaving:
            return requireAnswer(editor.IsQuitting());
        case Of::SamplesBelow:
            return require(samples < expected.number, std::to_string(samples));
        case Of::SamplesAbove:
            return require(samples > expected.number, std::to_string(samples));
    }
}

// --- Parsing ---

namespace {

template <typename... Values>
[[noreturn]] void Reject(fmt::format_string<Values...> format, Values&&... values) {
    throw MakeError(ErrorKind::Usage, format, std::forward<Values>(values)...);
}

// Parses a finite number within the range.
float Number(const std::string& word, float minimum, float maximum) {
    float value = 0.0f;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (failure != std::errc{} || end != word.data() + word.size() || !std::isfinite(value))
        Reject("{} is not a number", Quoted(word));
    if (value < minimum || value > maximum)
        Reject("{} is not from {:g} to {:g}", Quoted(word), minimum, maximum);
    return value;
}

uint32_t Count(const std::string& word) {
    constexpr float kMax = 1e6f;
    const float value = Number(word, 0.0f, kMax);
    if (value != std::floor(value)) Reject("{} is no whole number", Quoted(word));
    return static_cast<uint32_t>(value);
}

// Parses a position in pixels, at most far outside of any window.
glm::vec2 Place(const std::string& x, const std::string& y) {
    constexpr float kMax = 1e6f;
    return {Number(x, -kMax, kMax), Number(y, -kMax, kMax)};
}

rhi::Extent2D Size(const std::string& word) {
    constexpr float kMax = 16384.0f;
    const size_t x = word.find('x');
    if (x == std::string::npos) Reject("a size is WxH");
    return {static_cast<uint32_t>(Number(word.substr(0, x), 0.0f, kMax)),
            static_cast<uint32_t>(Number(word.substr(x + 1), 0.0f, kMax))};
}

MouseButton ButtonOf(const std::string& word) {
    if (word == "left") return MouseButton::Left;
    if (word == "right") return MouseButton::Right;
    if (word == "middle") return MouseButton::Middle;
    Reject("there is no mouse button {}", Quoted(word));
}

template <typename Choice>
Choice ChoiceOf(const std::string& name, const char* what) {
    for (const Choice choice : Values<Choice>())
        if (name == Name(choice)) return choice;
    Reject("there is no {} {}", what, Quoted(name));
}

viewport::View ViewOf(const std::string& name) {
    return ChoiceOf<viewport::View>(name, "view");
}

// Decodes the text, which is well-formed UTF-8.
std::u32string CodePoints(std::string_view text) {
    std::u32string points;
    for (const char character : text) {
        const auto byte = static_cast<unsigned char>(character);
        if ((byte & 0xC0u) == 0x80u)
            points.back() = points.back() << 6 | (byte & 0x3Fu);
        else
            points.push_back(byte < 0x80 ? byte : byte & (byte < 0xE0 ? 0x1Fu : byte < 0xF0 ? 0x0Fu : 0x07u));
    }
    return points;
}

// Reads the words of a line as values.
class LineReader {
  public:
    explicit LineReader(const std::vector<std::string>& words) : m_words(words) {}

    ScriptCommand Read() const {
        const std::string& verb = m_words[0];
        if (verb == "size") return SetSize{Size(Word(1))};
        if (verb == "scale") return SetScale{Number(Word(1), 0.5f, 8.0f)};
        if (verb == "open") return DropFile{Rest(1)};
        if (verb == "close") return CloseWindow{};
        if (verb == "key") {
            const KeyPress press = KeyFromText(Word(1));
            return PressKey{press.key, press.isControl, press.isShift};
        }
        if (verb == "mouse") return MoveMouse{Place(Word(1), Word(2))};
        if (verb == "press") return Held(true, false, false);
        if (verb == "release") return Held(false, true, false);
        if (verb == "click") return Held(true, true, false);
        if (verb == "drag") return Held(true, true, true);
        if (verb == "wheel") return ScrollWheel{Number(Word(1), -1e3f, 1e3f)};
        if (verb == "text") return TypeText{CodePoints(Rest(1))};
        if (verb == "select") return SelectNodes{Names(1)};
        if (verb == "frames") return AdvanceFrames{Count(Word(1))};
        if (verb == "wait") return WaitUntilDone{};
        if (verb == "samples") return WaitForSamples{Count(Word(1))};
        if (verb == "window" || verb == "picture") return SaveShown{Rest(1), verb == "window"};
        if (verb == "render") return FillRenderDialog{Size(Word(1)), Count(Word(2)), Rest(3)};
        if (verb == "fov") return SetLook{SetLook::Of::FieldOfView, Number(Word(1), 1.0f, 170.0f)};
        if (verb == "aperture") return SetLook{SetLook::Of::Aperture, Number(Word(1), 0.0f, 1e6f)};
        if (verb == "focus") return SetLook{SetLook::Of::Focus, Number(Word(1), 0.0f, 1e9f)};
        if (verb == "exposure") return SetLook{SetLook::Of::Exposure, Ranged(kExposureRange)};
        if (verb == "white-point") return SetLook{SetLook::Of::WhitePoint, Ranged(kWhitePointRange)};
        if (verb == "backdrop") return SetBackdrop{session::ParseBackdrop(Word(1))};
        if (verb == "ground" && (Word(1) == "on" || Word(1) == "off")) return SetGround{Word(1) == "on"};
        if (verb == "budget") return SetBudget{Number(Word(1), 0.0f, 1e6f)};
        if (verb == "config") return UseConfigFolder{Rest(1)};
        if (verb == "scene") return SaveSceneFile{Rest(1)};
        if (verb == "view") return ShowView{ViewOf(Rest(1))};
        if (verb == "compare")
            return CompareWith{ChoiceOf<viewport::Compared>(Word(1), "picture to compare")};
        if (verb == "denoise" && (Word(1) == "on" || Word(1) == "off")) return SetDenoised{Word(1) == "on"};
        if (verb == "variant") return ShowVariant{Rest(1)};
        if (verb == "play") return PlayFor{Number(Word(1), 0.0f, 600.0f)};
        if (verb == "time") return ShowTime{Number(Word(1), 0.0f, 1e6f)};
        if (verb == "stop") return StopPlaying{};
        if (verb == "clips") return ChooseClips{Rest(1)};
        if (verb == "material" && Word(1) == "base") return SetBaseColor{{Share(2), Share(3), Share(4)}};
        if (verb == "expect") return Expected();
        Reject("there is no such command");
    }

    std::string Rest(size_t from) const {
        Word(from);
        std::string text;
        for (size_t i = from; i < m_words.size(); ++i) text += (i > from ? " " : "") + m_words[i];
        return text;
    }

  private:
    // Reads a button with its modifiers, and the way of a drag.
    HoldButton Held(bool isDown, bool isUp, bool isDragged) const {
        const Modified modified = ModifiedFromText(Word(1));
        return {ButtonOf(std::string(modified.name)),
                isDown,
                isUp,
                isDragged,
                isDragged ? Place(Word(2), Word(3)) : glm::vec2(0.0f),
                modified.isControl,
                modified.isShift};
    }
    // Reads a list with commas.
    std::vector<std::string> Names(size_t from) const {
        std::istringstream list(Rest(from));
        std::vector<std::string> names;
        for (std::string name; std::getline(list >> std::ws, name, ',');) names.push_back(name);
        return names;
    }
    const std::string& Word(size_t i) const {
        if (i >= m_words.size()) Reject("a word is missing");
        return m_words[i];
    }
    float Ranged(const Range& range) const { return Number(Word(1), range.min, range.max); }
    // Reads a channel of a color.
    float Share(size_t i) const { return Number(Word(i), 0.0f, 1.0f); }

    Expectation Expected() const {
        using Of = Expectation::Of;
        const std::string& what = Word(1);
        const std::string value = Rest(2);
        if (what == "selected") return {Of::Selected, value};
        if (what == "view") return {Of::View, "", 0, ViewOf(value)};
        if (what == "variant") return {Of::Variant, value};
        if (what == "message") return {Of::Message, value};
        if (what == "time") return {Of::Time, value};
        if (what == "nodes") return {Of::Nodes, "", Count(value)};
        if (what == "edits") return {Of::Edits, "", Count(value)};
        if (what == "samples-below") return {Of::SamplesBelow, "", Count(value)};
        if (what == "samples-above") return {Of::SamplesAbove, "", Count(value)};
        const Of answer = what == "asking" ? Of::Asking : what == "leaving" ? Of::Leaving : Of::Playing;
        if (answer == Of::Playing && what != "playing") Reject("there is nothing of that name to expect");
        if (value != "yes" && value != "no") Reject("it is yes or no, not {}", Quoted(value));
        return {answer, "", value == "yes"};
    }

    const std::vector<std::string>& m_words;
};

}  // namespace

void ThrowLineError(const std::string& name, uint32_t number, std::string_view text, std::string_view why) {
    throw MakeError(ErrorKind::BadInput, "{}:{}: {}: {}", name, number, Printable(text), why);
}

std::vector<ScriptLine> ParseScript(std::string_view text, const std::string& name) {
    std::vector<ScriptLine> lines;
    for (uint32_t number = 1; !text.empty(); ++number) {
        const size_t end = std::min(text.find('\n'), text.size());
        const std::string line(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
        std::istringstream stream(line.substr(0, line.find('#')));
        std::vector<std::string> words;
        for (std::string word; stream >> word;) words.push_back(word);
        if (words.empty()) continue;
        const LineReader reader(words);
        const std::string whole = reader.Rest(0);
        if (Printable(whole, whole.size()) != whole)
            ThrowLineError(name, number, whole, "has control characters, or bytes that are no UTF-8");
        try {
            lines.push_back({number, whole, reader.Read()});
        } catch (const Error& error) {
            ThrowLineError(name, number, whole, error.what());
        }
    }
    return lines;
}

}  // namespace raygraph::editor
