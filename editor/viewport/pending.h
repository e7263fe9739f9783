// Pending is a request to a viewport that a later frame answers: asking and polling never wait for the
// device. Threads: that of the viewport; a request that is ready may be moved to another thread, which takes
// the result.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "renderer/graph/renderer.h"

namespace raygraph::viewport {

// Is a request, whose copies share its answer. If the frame that answers is dropped, the next one answers. A
// request that is unanswered when the viewport is destroyed never becomes ready.
template <typename Answer>
class Pending {
  public:
    // Returns whether a submitted frame has answered: later changes do not affect the result.
    bool IsTaken() const { return m_state && m_state->isTaken; }
    // Returns whether the device has finished that frame.
    bool IsReady() const {
        return IsTaken() && std::ranges::all_of(m_state->reply.readbacks, &Readback::IsReady);
    }
    // Throws Error{Usage} if it is not ready.
    Answer Result() const {
        if (!IsReady()) throw Error(ErrorKind::Usage, "Pending::Result: the answer is not there yet");
        return m_state->reply.finish();
    }

  private:
    template <typename, typename>
    friend class Questions;
    struct Reply {
        std::vector<Readback> readbacks;  // to be waited for
        std::function<Answer()> finish;   // called once these are ready
    };
    struct State {
        bool isTaken = false;
        Reply reply;
    };
    std::shared_ptr<State> m_state;
};

// Holds the requests that are not answered yet. `Subject` is what a request is about.
template <typename Answer, typename Subject>
class Questions {
  public:
    using Reply = typename Pending<Answer>::Reply;

    Pending<Answer> Ask(Subject subject) {
        Pending<Answer> pending;
        pending.m_state = std::make_shared<State>();
        m_open.emplace_back(std::move(subject), pending.m_state);
        return pending;
    }
    bool HasUnanswered() {
        std::erase_if(m_open, [](const auto& open) { return open.second->isTaken; });
        return !m_open.empty();
    }
    // Makes the open frame answer the requests: `reply` declares the answer for a subject, or is std::nullopt
    // where a later frame is to answer.
    template <typename MakeReply>
    void DeclareReplies(Renderer& renderer, MakeReply&& reply) {
        if (!HasUnanswered()) return;
        for (const auto& [subject, state] : m_open) {
            std::optional<Reply> made = reply(subject);
            if (!made) continue;
            state->reply = std::move(*made);
            renderer.OnSubmitted([state = state] { state->isTaken = true; });
        }
    }

  private:
    using State = typename Pending<Answer>::State;
    std::vector<std::pair<Subject, std::shared_ptr<State>>> m_open;
};

}  // namespace raygraph::viewport
