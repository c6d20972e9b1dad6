//! Points, lines and rectangles in a drawing.

/// A point (x, y), in data coordinates (usually mm) or on the sheet (px).
pub type Point = [f64; 2];

/// Several lines, each given by its points in order.
pub type Lines = Vec<Vec<Point>>;

/// A rectangle on the sheet with horizontal and vertical sides, px; y grows downwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Area {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Area {
    /// The rectangle with this centre, width and height, px.
    pub(super) fn about([x, y]: Point, width: f64, height: f64) -> Self {
        Self { left: x - width / 2.0, top: y - height / 2.0, right: x + width / 2.0, bottom: y + height / 2.0 }
    }

    /// The rectangle between two opposite corners, px.
    pub(super) fn between(a: Point, b: Point) -> Self {
        Self { left: a[0].min(b[0]), top: a[1].min(b[1]), right: a[0].max(b[0]), bottom: a[1].max(b[1]) }
    }

    /// The smallest rectangle that contains all points, px.
    pub(super) fn around(points: impl Iterator<Item = Point>) -> Self {
        let areas = points.map(|point| Self::between(point, point));
        let join = |a: Self, b: Self| Self {
            left: a.left.min(b.left),
            top: a.top.min(b.top),
            right: a.right.max(b.right),
            bottom: a.bottom.max(b.bottom),
        };
        areas.reduce(join).unwrap_or(Self::between([0.0, 0.0], [0.0, 0.0]))
    }

    pub(super) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(super) fn height(&self) -> f64 {
        self.bottom - self.top
    }

    pub(super) fn centre(&self) -> Point {
        between([self.left, self.top], [self.right, self.bottom], 0.5)
    }

    /// Outline of the rectangle as a closed line, px.
    pub(super) fn outline(&self) -> [Point; 5] {
        let Self { left, top, right, bottom } = *self;
        [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]]
    }

    /// Horizontal line from edge to edge through the centre of the rectangle, px.
    pub(super) fn level(&self) -> [Point; 2] {
        [self.left, self.right].map(|x| [x, self.centre()[1]])
    }

    /// Whether this rectangle contains the other.
    pub(super) fn holds(&self, other: &Self) -> bool {
        let across = self.left <= other.left && other.right <= self.right;
        across && self.top <= other.top && other.bottom <= self.bottom
    }

    /// Whether two rectangles overlap.
    pub(super) fn meets(&self, other: &Self) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }

    /// The part of a line segment that lies inside the rectangle (Liang and Barsky); `None` if no part does.
    pub(super) fn clip(&self, from: Point, to: Point) -> Option<[Point; 2]> {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let sides = [
            (-dx, from[0] - self.left),
            (dx, self.right - from[0]),
            (-dy, from[1] - self.top),
            (dy, self.bottom - from[1]),
        ];
        for (step, room) in sides {
            match step {
                0.0 if room < 0.0 => return None,
                0.0 => {}
                step if step < 0.0 => enter = enter.max(room / step),
                step => leave = leave.min(room / step),
            }
        }
        (enter <= leave).then(|| [between(from, to, enter), between(from, to, leave)])
    }
}

/// The line segments between successive points of the lines.
pub(super) fn segments<'a>(lines: impl IntoIterator<Item = &'a Vec<Point>>) -> impl Iterator<Item = [Point; 2]> {
    lines.into_iter().flat_map(|line| line.windows(2)).map(|pair| [pair[0], pair[1]])
}

/// Distance between two points, in the unit of the points.
pub(super) fn distance(a: Point, b: Point) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// The point at a share, 0 to 1, of the distance from `a` to `b`.
pub(super) fn between(a: Point, b: Point, part: f64) -> Point {
    [a[0] + (b[0] - a[0]) * part, a[1] + (b[1] - a[1]) * part]
}

/// The point at the distance `length` from `from` in a direction (unit vector).
pub(super) fn along(from: Point, direction: Point, length: f64) -> Point {
    [from[0] + direction[0] * length, from[1] + direction[1] * length]
}

/// The unit vector from `a` to `b`; `None` if the points coincide.
pub(super) fn direction(a: Point, b: Point) -> Option<Point> {
    let length = distance(a, b);
    (length > 0.0).then(|| [(b[0] - a[0]) / length, (b[1] - a[1]) / length])
}

/// Distance of a point from a line segment, in the unit of the points.
pub(super) fn gap(at: Point, [from, to]: [Point; 2]) -> f64 {
    let along = direction(from, to).unwrap_or([0.0, 0.0]);
    let reach = (at[0] - from[0]) * along[0] + (at[1] - from[1]) * along[1];
    distance(at, self::along(from, along, reach.clamp(0.0, distance(from, to))))
}
