"""Errors on logarithmic axes, as SVG."""
import math

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 640, 420, 70, 24, 40, 56
# Told apart by the colour-blind as well (Okabe & Ito 2008).
COLOURS = ["#0072b2", "#d55e00", "#009e73"]


def ticks(low, high):
    """1, 2 and 5 times powers of ten between them."""
    return [m * 10.0**e for e in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1) for m in (1, 2, 5)
            if low <= m * 10.0**e <= high]


def slope_of(points):
    """The power of the first number that the second goes with, by least squares."""
    x, y = ([math.log(p[i]) for p in points] for i in (0, 1))
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / sum((a - mean_x)**2 for a in x)


def draw_errors(path, curves, x_title, y_title):
    """`curves`: names and lists of points."""
    xs = [p[0] for _, points in curves for p in points]
    ys = [p[1] for _, points in curves for p in points]
    x_range, y_range = (min(xs) / 1.3, max(xs) * 1.3), (min(ys) / 1.4, max(ys) * 1.4)

    def place(value, bounds, low, high):
        return low + (high - low) * math.log(value / bounds[0]) / math.log(bounds[1] / bounds[0])

    def at(point):
        return place(point[0], x_range, LEFT, WIDTH - RIGHT), place(point[1], y_range, HEIGHT - BOTTOM, TOP)

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" '
             f'font-size="12">', f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>']
    for x in ticks(*x_range):
        px = at((x, ys[0]))[0]
        parts.append(f'<path d="M{px:.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#ddd"/>'
                     f'<text x="{px:.1f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{x:,g}</text>')
    for y in ticks(*y_range):
        py = at((xs[0], y))[1]
        parts.append(f'<path d="M{LEFT} {py:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
                     f'<text x="{LEFT - 8}" y="{py + 4:.1f}" text-anchor="end">{y:g}</text>')
    parts.append(f'<rect x="{LEFT}" y="{TOP}" width="{WIDTH - LEFT - RIGHT}" height="{HEIGHT - TOP - BOTTOM}" fill="none" '
                 f'stroke="#444"/>')
    parts.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 14}" text-anchor="middle">{x_title}</text>'
                 f'<text x="{LEFT}" y="{TOP - 14}">{y_title}</text>')
    for number, (name, points) in enumerate(curves):
        colour = COLOURS[number % len(COLOURS)]
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(at, points))
        parts.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"/>')
        for x, y in map(at, points):
            parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>')
        x, y = at(points[0])
        power = f" (power {slope_of(points):.2f})" if len(points) > 1 else ""
        parts.append(f'<text x="{x + 10:.1f}" y="{y - 10:.1f}" fill="{colour}">{name}{power}</text>')
    path.write_text("\n".join(parts) + "\n</svg>\n")
