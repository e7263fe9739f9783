// How paths are traced, as TraceSettings, the viewport and the program's settings each have it among others.
// Threads: any.
#pragma once

namespace raygraph::passes {

// Copies what decides the samples of a picture beside its camera and extent. The one list of it: a setting of
// paths that is added to TraceSettings is added here.
template <typename From, typename To>
void CopyPathSettings(const From& from, To& to) {
    to.sampler = from.sampler;
    to.seed = from.seed;
    to.scattering = from.scattering;
    to.lights = from.lights;
    to.roulette = from.roulette;
    to.biases = from.biases;
}

}  // namespace raygraph::passes
