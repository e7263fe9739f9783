#include "editor/app/render_queue.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::editor {

namespace {

constexpr int kTryAgain = 75;  // exit status of a render that SIGTERM has ended (docs/cli.md)

}  // namespace

PrivateCopy::~PrivateCopy() {
    std::error_code ignored;
    std::filesystem::remove_all(m_file.parent_path(), ignored);
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
}

const RenderQueue::Job* RenderQueue::Running() const {
    const auto job = std::ranges::find(m_jobs, State::Running, &Job::state);
    return job == m_jobs.end() ? nullptr : &*job;
}

bool RenderQueue::IsBusy() const {
    return !std::ranges::all_of(m_jobs, &Job::IsOver);
}

void RenderQueue::ReadLines(Job& job) {
    const std::string_view text = m_process->Written();
    for (size_t end = text.find('\n', m_read); end != text.npos; end = text.find('\n', m_read)) {
        const std::string_view line = text.substr(m_read, end - m_read);
        m_read = end + 1;
        if (!ReadProgress(line, job.progress) && !line.empty()) m_lastMessage = Printable(line);
    }
}

void RenderQueue::End(Job& job) {
    const std::optional<int> status = m_process->ExitStatus();
    m_process.reset();
    job.task.copy.reset();
    const std::string& name = job.task.name;
    const std::string& said = m_lastMessage;
    if (status == 0) {
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
    job.state = State::Running;
    m_read = 0;
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
    if (next != m_jobs.end()) Start(*next);
    return nullptr;
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
