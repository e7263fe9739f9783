#include "editor/app/render_queue.h"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::editor {

namespace fs = std::filesystem;

namespace {

constexpr int kTryAgain = 75;  // exit status of a render that SIGTERM has ended (docs/cli.md)

}  // namespace

PrivateCopy::~PrivateCopy() {
    std::error_code ignored;
    fs::remove_all(m_file.parent_path(), ignored);
}

void SweepCopies(const fs::path& folder) {
    constexpr std::chrono::hours kWeek{7 * 24};
    std::error_code error;
    std::vector<fs::path> old;
    for (fs::directory_iterator end, each(folder, error); !error && each != end; each.increment(error)) {
        std::error_code unknown;
        const auto age = fs::file_time_type::clock::now() - fs::last_write_time(*each, unknown);
        if (!unknown && age > kWeek) old.push_back(*each);
    }
    for (const fs::path& each : old) fs::remove_all(each, error);
}

bool ReadProgress(std::string_view line, RenderProgress& progress) {
    if (!line.starts_with('{')) return false;
    const nlohmann::json json = nlohmann::json::parse(line, nullptr, false);
    const auto textOf = [&](const char* name) {
        const auto value = json.find(name);
        return value != json.end() && value->is_string() ? Printable(value->get<std::string>()) : "";
    };
    const auto numberOf = [&](const char* name) {
        const auto value = json.find(name);
        return value != json.end() && value->is_number() ? value->get<double>() : 0.0;
    };
    const std::string event = json.is_object() ? textOf("event") : "";
    if (event.empty()) return false;
    if (event == "loading") {
        progress.text = Text("loading {}", textOf("stage"));
    } else if (event == "step") {
        progress.text = textOf("step");
    } else if (event == "written") {
        ++progress.written;
        progress.fraction = 0.0f;
    } else if (event == "progress") {
        const double done = numberOf("samples"), wanted = numberOf("samples_wanted");
        progress.text = textOf("picture");
        if (!progress.text.empty()) progress.text += ": ";
        progress.text +=
            wanted > 0.0 ? Text("{:.0f} of {:.0f} samples", done, wanted) : Text("{:.0f} samples", done);
        if (const double error = numberOf("relative_error"); error > 0.0)
            progress.text += Text(", error {:.2g} %", 100.0 * error);
        if (const double left = numberOf("seconds_left"); left > 0.0)
            progress.text += Text(", {} left", DurationText(left));
        progress.fraction = wanted > 0.0 ? static_cast<float>(std::clamp(done / wanted, 0.0, 1.0)) : 0.0f;
    }
    return true;
}

float RenderQueue::Job::Fraction() const {
    const float pictures = static_cast<float>(std::max(task.pictures, 1u));
    return std::min((static_cast<float>(progress.written) + progress.fraction) / pictures, 1.0f);
}

RenderQueue::~RenderQueue() {
    for (size_t i = 0; i < m_jobs.size(); ++i) Cancel(i);
}

void RenderQueue::Add(RenderTask task) {
    m_jobs.push_back({.task = std::move(task)});
    ++m_addedCount;
}

const RenderQueue::Job* RenderQueue::Running() const {
    const auto job = std::ranges::find(m_jobs, State::Running, &Job::state);
    return job == m_jobs.end() ? nullptr : &*job;
}

bool RenderQueue::IsBusy() const {
    return !std::ranges::all_of(m_jobs, &Job::IsOver);
}

bool RenderQueue::IsWriting(const fs::path& file) const {
    const auto nameOf = [](const fs::path& path) {
        std::error_code error;
        const fs::path whole = fs::absolute(path, error), canonical = fs::weakly_canonical(whole, error);
        return error ? whole : canonical;
    };
    const fs::path name = nameOf(file);
    return std::ranges::any_of(m_jobs, [&](const Job& job) {
        return !job.IsOver() && std::ranges::count(job.task.outputs, name, nameOf) > 0;
    });
}

void RenderQueue::ReadLines(Job& job) {
    m_unread += m_process->TakeWritten();
    size_t start = 0;
    for (size_t end = 0; (end = m_unread.find('\n', start)) != m_unread.npos; start = end + 1)
        ReadLine(job, std::string_view(m_unread).substr(start, end - start));
    m_unread.erase(0, start);
}

void RenderQueue::ReadLine(Job& job, std::string_view line) {
    if (!ReadProgress(line, job.progress) && !line.empty()) m_lastMessage = Printable(line);
}

void RenderQueue::End(Job& job) {
    const std::optional<int> status = m_process->ExitStatus();
    const bool isStarted = m_process->IsStarted();
    m_process.reset();
    ReadLine(job, std::exchange(m_unread, {}));  // the last line may have no end
    job.task.copy.reset();
    const std::string& name = job.task.name;
    const std::string& said = m_lastMessage;
    if (!isStarted) {
        job.state = State::Failed;
        job.result =
            Text("{}: not rendered: {} could not be started", name, Printable(job.task.command.front()));
    } else if (status == 0) {
        job.state = State::Done;
        job.result = Text("rendered {}{}{}", name, said.empty() ? "" : ": ", said);
    } else if (m_isStopping && status == kTryAgain && job.progress.written > 0) {
        job.state = State::Stopped;
        job.result = Text("stopped, {} saved: {}", name, said);
    } else if (m_isStopping && (!status || status == kTryAgain)) {
        job.state = State::Cancelled;
        job.result = Text("{}: stopped before there was a sample", name);
    } else {
        job.state = State::Failed;
        job.result = Text("{}: not rendered: {}", name, said.empty() ? "the program ended" : said);
    }
}

void RenderQueue::Start(Job& job) {
    const RenderTask& task = job.task;
    if (task.stamp && StampOf(task.scene) != task.stamp) {
        job.state = State::Failed;
        job.result = Text("{}: not rendered: {} has changed since it was queued", task.name, task.scene);
        return;
    }
    job.state = State::Running;
    m_unread.clear();
    m_lastMessage.clear();
    m_isStopping = false;
    m_process = std::make_unique<os::ChildProcess>(job.task.command, os::ErrorStream::WithOutput);
}

const RenderQueue::Job* RenderQueue::Update() {
    const auto running = std::ranges::find(m_jobs, State::Running, &Job::state);
    if (running != m_jobs.end()) {
        const bool isRunning = m_process->IsRunning();
        ReadLines(*running);
        if (isRunning) return nullptr;
        End(*running);
        return &*running;
    }
    const auto next = std::ranges::find(m_jobs, State::Waiting, &Job::state);
    if (next == m_jobs.end()) return nullptr;
    Start(*next);
    return next->IsOver() ? &*next : nullptr;
}

void RenderQueue::Cancel(size_t index) {
    Job& job = m_jobs.at(index);
    if (job.IsOver()) return;
    if (job.state == State::Running) {
        m_process->Kill();
        m_process.reset();
    }
    job.state = State::Cancelled;
    job.task.copy.reset();
    job.result = Text("{}: cancelled", job.task.name);
}

void RenderQueue::Stop(size_t index) {
    if (m_jobs.at(index).state != State::Running || std::exchange(m_isStopping, true)) return;
    m_process->Terminate();
}

void RenderQueue::RemoveOver() {
    std::erase_if(m_jobs, [](const Job& job) { return job.IsOver(); });
}

const char* Name(RenderQueue::State state) {
    switch (state) {
        case RenderQueue::State::Waiting:
            return "waiting";
        case RenderQueue::State::Running:
            return "rendering";
        case RenderQueue::State::Done:
            return "done";
        case RenderQueue::State::Stopped:
            return "stopped and saved";
        case RenderQueue::State::Cancelled:
            return "cancelled";
        case RenderQueue::State::Failed:
            return "failed";
    }
    return "";
}

}  // namespace raygraph::editor
