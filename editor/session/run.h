// Defines when a run of samples ends, and its progress. Threads: plain values.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

namespace raygraph::session {

// A run ends with the first of these limits; one of the first three must be set.
struct StopRule {
    std::optional<uint32_t> samples;  // total of the picture, earlier runs included
    std::optional<double> seconds;    // limit of this run; at least one sample is rendered
    // See ImageStatistics; it is not measured before 64 samples. A picture that is black without any variance
    // counts as done then.
    std::optional<double> relativeError;
    std::function<bool()> isStopRequested;  // called after each sample, see Session::Run; empty: never stops
    // Ends the run so that another one can continue; called only after the run has a sample.
    std::function<bool()> isPauseRequested;
};

// Holds the state of a run that is going on.
struct ProgressState {
    uint32_t samplesDone = 0;               // samples of the picture
    std::optional<uint32_t> samplesWanted;  // none: until the time is up
    double samplesPerSecond = 0.0;          // over all pixels; 0: not known yet
    std::optional<double> relativeError;    // with variance, from time to time
    std::optional<double> secondsLeft;      // until the first limit of the rule, except for the error
    // Is set before the first sample of a run, when everything but the wanted samples is unknown: the number
    // of samplesDone, which were resumed, whose albedo and normals have been traced again (Session::Run).
    std::optional<uint32_t> samplesRestored;
};

struct RunSummary {
    double seconds = 0.0;                    // time of sampling
    double firstSampleSeconds = 0.0;         // part of it until the first sample, with pipelines and uploads
    std::optional<double> samplesPerSecond;  // over all pixels, without the first sample; none for one sample
    bool wasStopped = false;                 // ended early by isStopRequested or isPauseRequested
};

}  // namespace raygraph::session
