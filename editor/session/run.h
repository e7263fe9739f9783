// When a run of samples ends, and how it gets on. Threads: plain values.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

namespace raygraph::session {

// A run ends with the first of these; one of the first three is set.
struct StopRule {
    std::optional<uint32_t> samples;  // in the picture, with those of earlier runs
    std::optional<double> seconds;    // of this run; at least one sample is rendered
    // As of ImageStatistics; not before 64 samples. A picture that is black without any variance then has
    // none to fall, and is done.
    std::optional<double> relativeError;
    std::function<bool()> isStopRequested;  // asked after each sample, see Session::Run; empty: never
    // The same, to go on with another run: not asked before there is a sample of this one.
    std::function<bool()> isPauseRequested;
};

// While a run is going on.
struct ProgressState {
    uint32_t samplesDone = 0;               // in the picture
    std::optional<uint32_t> samplesWanted;  // none: until the time is up
    double samplesPerSecond = 0.0;          // of all pixels; 0: not known yet
    std::optional<double> relativeError;    // with variance: from time to time
    std::optional<double> secondsLeft;      // until the first of the rule's limits, but for the error
    // Before the first sample of a run, when nothing else but the wanted ones is known: of how many of the
    // samplesDone, which were resumed, albedo and normals have been traced again (Session::Run).
    std::optional<uint32_t> samplesRestored;
};

struct RunSummary {
    double seconds = 0.0;             // of sampling
    double firstSampleSeconds = 0.0;  // of these, until the first was done, pipelines and uploads included
    std::optional<double> samplesPerSecond;  // of all pixels, without the first; none for one sample
    bool wasStopped = false;  // before the rule's samples or error, because it or a pause was requested
};

}  // namespace raygraph::session
