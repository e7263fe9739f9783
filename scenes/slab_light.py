"""What a slab of a medium that scatters returns in light from all sides, computed without random numbers by
doubling (van de Hulst 1963; Hansen and Travis 1974, "Light Scattering in Planetary Atmospheres"): from a
layer so thin that light scatters once in it, to ever thicker ones."""

import math

NODES = 8


def legendre(order, x):
    """P_order and its derivative."""
    before, value = 1.0, x
    for n in range(2, order + 1):
        before, value = value, ((2 * n - 1) * x * value - (n - 1) * before) / n
    return value, order * (x * value - before) / (x * x - 1)


def gauss_nodes(count):
    """Nodes and weights of Gauss and Legendre's quadrature on 0 ... 1."""
    nodes, weights = [], []
    for i in range(count):
        x = math.cos(math.pi * (i + 0.75) / (count + 0.5))
        for _ in range(50):
            value, slope = legendre(count, x)
            x -= value / slope
        slope = legendre(count, x)[1]
        nodes.append((1 + x) / 2)
        weights.append(1 / ((1 - x * x) * slope * slope))
    return nodes, weights


def returned_light(albedo, g, depth):
    """The radiance towards the normal of a slab, in light of radiance 1 from all directions: `depth` mean
    free paths thick, single-scattering albedo, mean cosine g of Henyey and Greenstein's phase function."""
    nodes, weights = gauss_nodes(NODES)
    nodes, weights = nodes + [1.0], weights + [0.0]  # the direction that is asked for
    size = len(nodes)
    legendres = [[1.0, mu] for mu in nodes]
    for values, mu in zip(legendres, nodes):
        for n in range(2, 2 * NODES):
            values.append(((2 * n - 1) * mu * values[-1] - (n - 1) * values[-2]) / n)

    def phase(i, k, sign):
        """Its mean over the azimuth."""
        return sum((2 * n + 1) * (g * sign) ** n * legendres[i][n] * legendres[k][n]
                   for n in range(2 * NODES))

    def times(a, b):
        columns = list(zip(*b))
        scaled = [[2 * value * mu * w for value, mu, w in zip(row, nodes, weights)] for row in a]
        return [[sum(map(float.__mul__, row, column)) for column in columns] for row in scaled]

    def plus(*matrices):
        return [[sum(values) for values in zip(*rows)] for rows in zip(*matrices)]

    doublings = max(1, math.ceil(math.log2(depth * 2.0 ** 22)))
    thin = depth / 2.0 ** doublings
    pairs = [[albedo * thin / (4 * a * b) for b in nodes] for a in nodes]
    back = [[pairs[i][k] * phase(i, k, -1) for k in range(size)] for i in range(size)]
    through = [[pairs[i][k] * phase(i, k, 1) for k in range(size)] for i in range(size)]
    for step in range(doublings):
        direct = [math.exp(-thin * 2.0 ** step / mu) for mu in nodes]
        after = lambda m: [[value * e for value, e in zip(row, direct)] for row in m]
        before = lambda m: [[value * e for value in row] for row, e in zip(m, direct)]
        # Light between the two halves: all numbers of reflections.
        once = times(back, back)
        power, between = once, once
        while max(map(max, power)) > 1e-9:
            between = plus(between, times(power, between))
            power = times(power, power)
        down = plus(through, after(between), times(between, through))
        up = plus(after(back), times(back, down))
        back = plus(back, before(up), times(through, up))
        through = plus(before(down), after(through), times(through, down))
    seen = sum(2 * mu * w * (r + t) for mu, w, r, t in zip(nodes, weights, back[-1], through[-1]))
    return seen + math.exp(-depth)
