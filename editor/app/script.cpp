#include "editor/app/script.h"

#include <charconv>
#include <chrono>
#include <fstream>
#include <sstream>

#include "base/error.h"

namespace raygraph::editor {

namespace {

constexpr int kDragSteps = 8;
constexpr std::chrono::seconds kMostWait{300};

float Number(const std::string& word) {
    float value = 0.0f;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (failure != std::errc{} || end != word.data() + word.size())
        throw Error(ErrorKind::Usage, "'" + word + "' is no number");
    return value;
}

MouseButton ButtonOf(const std::string& word) {
    if (word == "left") return MouseButton::Left;
    if (word == "right") return MouseButton::Right;
    if (word == "middle") return MouseButton::Middle;
    throw Error(ErrorKind::Usage, "there is no mouse button '" + word + "'");
}

viewport::View ViewOf(const std::string& name) {
    for (uint32_t i = 0; i < viewport::kViewCount; i++)
        if (name == Name(static_cast<viewport::View>(i))) return static_cast<viewport::View>(i);
    throw Error(ErrorKind::Usage, "there is no view '" + name + "'");
}

std::string Rest(const std::vector<std::string>& words, size_t from) {
    std::string text;
    for (size_t i = from; i < words.size(); i++) text += (i > from ? " " : "") + words[i];
    return text;
}

}  // namespace

Script::Script(const std::filesystem::path& file) : m_file(file) {
    m_input.extent = {1280, 720};
    std::ifstream stream(file);
    if (!stream) throw Error(ErrorKind::Io, file.string() + ": cannot be read");
    std::string text;
    for (uint32_t number = 1; std::getline(stream, text); number++) {
        std::istringstream words(text.substr(0, text.find('#')));
        Line line{.number = number, .words = {}};
        for (std::string word; words >> word;) line.words.push_back(word);
        if (!line.words.empty()) m_lines.push_back(std::move(line));
    }
}

void Script::Fail(const Line& line, const std::string& why) const {
    throw Error(ErrorKind::BadInput, m_file.string() + ":" + std::to_string(line.number) + ": " +
                                         Rest(line.words, 0) + ": " + why);
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

void Script::Play(Editor& editor, Screen& screen) {
    Frame(editor, screen);
    for (const Line& line : m_lines) {
        try {
            Do(line, editor, screen);
        } catch (const Error& error) {
            if (error.Kind() != ErrorKind::Usage) throw;
            Fail(line, error.what());
        }
    }
    editor.KeepSettings();
}

void Script::Do(const Line& line, Editor& editor, Screen& screen) {
    const std::vector<std::string>& words = line.words;
    const std::string& verb = words[0];
    const auto word = [&](size_t i) -> const std::string& {
        if (i >= words.size()) Fail(line, "a word is missing");
        return words[i];
    };
    const auto hold = [&](MouseButton button, bool isDown) {
        m_input.buttons[static_cast<size_t>(button)] = isDown;
        Frame(editor, screen);
    };
    const auto until = [&](const char* what, auto&& isDone) {
        const auto start = std::chrono::steady_clock::now();
        while (std::chrono::steady_clock::now() - start < kMostWait) {
            Frame(editor, screen);
            if (isDone()) return;
        }
        Fail(line, std::string("still not ") + what + " after " + std::to_string(kMostWait.count()) + " s; " +
                       editor.Work().message);
    };
    if (verb == "size") {
        const size_t x = word(1).find('x');
        if (x == std::string::npos) Fail(line, "a size is WxH");
        const auto side = [&](const std::string& text) {
            const float pixels = Number(text);
            if (!(pixels >= 0.0f && pixels <= 16384.0f)) Fail(line, "a side has 0 to 16384 pixels");
            return static_cast<uint32_t>(pixels);
        };
        m_input.extent = {side(word(1).substr(0, x)), side(word(1).substr(x + 1))};
        Frame(editor, screen);
    } else if (verb == "scale") {
        m_input.scale = Number(word(1));
        if (!(m_input.scale >= 0.5f && m_input.scale <= 8.0f)) Fail(line, "a scale is 0.5 to 8");
        Frame(editor, screen);
    } else if (verb == "open") {
        m_input.dropped.emplace_back(Rest(words, 1));
        Frame(editor, screen);
    } else if (verb == "close") {
        m_input.isClosing = true;
        Frame(editor, screen);
        Frame(editor, screen);  // with what it asks
    } else if (verb == "key") {
        std::string name = word(1);
        for (size_t plus = name.find('+'); plus != std::string::npos; plus = name.find('+')) {
            const std::string modifier = name.substr(0, plus);
            if (modifier == "ctrl") m_input.isControl = true;
            if (modifier == "shift") m_input.isShift = true;
            name = name.substr(plus + 1);
        }
        const Key key = KeyFromName(name);
        m_input.pressed.push_back(key);
        m_input.keys[static_cast<size_t>(key)] = true;
        Frame(editor, screen);
        m_input.keys[static_cast<size_t>(key)] = false;
        m_input.isControl = m_input.isShift = false;
        Frame(editor, screen);
    } else if (verb == "mouse") {
        m_input.mouse = {Number(word(1)), Number(word(2))};
        Frame(editor, screen);
    } else if (verb == "press") {
        hold(ButtonOf(word(1)), true);
    } else if (verb == "release") {
        hold(ButtonOf(word(1)), false);
    } else if (verb == "click") {
        hold(ButtonOf(word(1)), true);
        hold(ButtonOf(word(1)), false);
    } else if (verb == "drag") {
        const glm::vec2 way(Number(word(2)), Number(word(3)));
        hold(ButtonOf(word(1)), true);
        for (int i = 0; i < kDragSteps; i++) {
            m_input.mouse += way / float(kDragSteps);
            Frame(editor, screen);
        }
        hold(ButtonOf(word(1)), false);
    } else if (verb == "wheel") {
        m_input.wheel = Number(word(1));
        Frame(editor, screen);
    } else if (verb == "text") {
        for (const char character : Rest(words, 1)) m_input.text.push_back(static_cast<char32_t>(character));
        Frame(editor, screen);
    } else if (verb == "frames") {
        for (float i = 0; i < Number(word(1)); i++) Frame(editor, screen);
    } else if (verb == "wait") {
        until("done", [&] { return !editor.IsBusy(); });
    } else if (verb == "samples") {
        const auto wanted = static_cast<uint32_t>(Number(word(1)));
        until("there", [&] {
            const viewport::ViewportProgress progress = editor.Work().view.Progress();
            const viewport::View view = editor.Work().view.Show().view;
            return (!ShowsPathTraced(view) || progress.pathTracedSamples >= wanted) &&
                   (!ShowsRaster(view) ||
                    (progress.rasterSamples > 0 && (progress.rasterSamples >= wanted ||
                                                    progress.rasterSamples == progress.rasterSamplesWanted)));
        });
    } else if (verb == "window" || verb == "picture") {
        if (verb == "window")
            editor.SaveWindow(Rest(words, 1));
        else
            editor.SavePicture(Rest(words, 1));
        until("saved", [&] { return !editor.IsBusy(); });
        if (!std::filesystem::exists(Rest(words, 1))) Fail(line, editor.Work().message);
    } else if (verb == "budget") {
        viewport::BudgetSettings budget = editor.Work().view.Budget();
        budget.frameMs = Number(word(1));
        if (!(budget.frameMs >= 0.0)) Fail(line, "a budget is 0 or more milliseconds");
        editor.Work().view.SetBudget(budget);
    } else if (verb == "config") {
        editor.UseConfig(Rest(words, 1));
        Frame(editor, screen);
    } else if (verb == "scene") {
        if (!editor.SaveScene(Rest(words, 1))) Fail(line, editor.Work().message);
        Frame(editor, screen);
    } else if (verb == "view") {
        editor.Work().view.SetView(ViewOf(Rest(words, 1)));
        Frame(editor, screen);
    } else if (verb == "material" && word(1) == "base") {
        Workspace& work = editor.Work();
        if (!work.selectedMaterial) Fail(line, "no material is selected");
        scene::Material material = work.document.Scene().materials[*work.selectedMaterial];
        material.baseColorFactor = {Number(word(2)), Number(word(3)), Number(word(4)), 1.0f};
        work.Apply(MaterialEdit{*work.selectedMaterial, material});
        work.document.Settle();
        Frame(editor, screen);
    } else if (verb == "expect") {
        Expect(line, editor);
    } else {
        Fail(line, "there is no such command");
    }
}

void Script::Expect(const Line& line, Editor& editor) const {
    if (line.words.size() < 3) Fail(line, "a word is missing");
    Workspace& work = editor.Work();
    const std::string& what = line.words[1];
    const std::string value = Rest(line.words, 2);
    const auto require = [&](bool holds, const std::string& actual) {
        if (!holds) Fail(line, "it is '" + actual + "'");
    };
    if (what == "selected") {
        const std::string name =
            work.selectedNode ? work.document.Scene().nodes[*work.selectedNode].name : "nothing";
        require(name == value, name);
    } else if (what == "view") {
        require(value == Name(work.view.Show().view), Name(work.view.Show().view));
    } else if (what == "message") {
        require(work.message.find(value) != std::string::npos, work.message);
    } else if (what == "edits") {
        const auto count = static_cast<float>(work.document.EditCount());
        require(count == Number(value), std::to_string(work.document.EditCount()));
    } else if (what == "asking" || what == "leaving") {
        const bool holds = what == "asking" ? editor.IsAsking() : editor.IsLeaving();
        require(value == (holds ? "yes" : "no"), holds ? "yes" : "no");
    } else if (what == "samples-below") {
        const uint32_t samples = work.view.Progress().pathTracedSamples;
        require(static_cast<float>(samples) < Number(value), std::to_string(samples));
    } else if (what == "samples-above") {
        const uint32_t samples = work.view.Progress().pathTracedSamples;
        require(static_cast<float>(samples) > Number(value), std::to_string(samples));
    } else {
        Fail(line, "there is nothing of that name to expect");
    }
}

}  // namespace raygraph::editor
