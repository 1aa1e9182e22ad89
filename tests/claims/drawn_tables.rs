//! Tables drawn with known truth: shapes on a ground, their edges antialiased, in a light that may fall off, with noise,
//! stored in 8 or in 12 bits.
//!
//!   picture = quantised(light · (ground, then shape after shape) + noise)

use landmarkd_core::imaging::{Frame, Image};

use crate::random::Random;

/// Points a pixel along each axis: an edge has levels in between.
const POINTS: usize = 4;

/// A colour, gray levels of red, green and blue.
pub type Colour = [f64; 3];

/// An outline about its own middle.
#[derive(Clone, Copy)]
pub enum Shape {
    /// Of a radius.
    Disc(f64),
    /// Outer and inner radius.
    Ring(f64, f64),
    /// Half axes.
    Ellipse(f64, f64),
    /// Half sides.
    Bar(f64, f64),
    /// Half sides of a frame, and the breadth of its border.
    Border(f64, f64, f64),
    /// A bar of half sides with a disc of a radius at either end: one part with a narrow middle.
    Spanner(f64, f64, f64),
}

impl Shape {
    fn covers(self, x: f64, y: f64) -> bool {
        match self {
            Shape::Disc(radius) => x.hypot(y) <= radius,
            Shape::Ring(outer, inner) => (inner..=outer).contains(&x.hypot(y)),
            Shape::Ellipse(a, b) => (x / a).powi(2) + (y / b).powi(2) <= 1.0,
            Shape::Bar(a, b) => x.abs() <= a && y.abs() <= b,
            Shape::Border(a, b, breadth) => {
                x.abs() <= a && y.abs() <= b && !(x.abs() < a - breadth && y.abs() < b - breadth)
            }
            Shape::Spanner(a, b, radius) => {
                (x.abs() <= a && y.abs() <= b) || (x.abs() - a).hypot(y) <= radius
            }
        }
    }

    /// No point of it is farther from its middle.
    fn reach(self) -> f64 {
        match self {
            Shape::Disc(radius) | Shape::Ring(radius, _) => radius,
            Shape::Ellipse(a, b) => a.max(b),
            Shape::Bar(a, b) | Shape::Border(a, b, _) => a.hypot(b),
            Shape::Spanner(a, _, radius) => a + radius,
        }
    }
}

/// What lies on the table, or is printed on it.
#[derive(Clone, Copy)]
pub struct Drawn {
    pub shape: Shape,
    pub at_px: [f64; 2],
    pub turn_deg: f64,
    pub colour: Colour,
    /// Its light by that of what is beneath, for a shadow: `colour` doesn't count then.
    pub shade: Option<f64>,
    /// How far its edge fades, for a shadow.
    pub is_part: bool,
}

impl Drawn {
    pub fn part(shape: Shape, at_px: [f64; 2], turn_deg: f64, colour: Colour) -> Drawn {
        Drawn { shape, at_px, turn_deg, colour, shade: None, is_part: true }
    }

    /// A mark that is no part.
    pub fn mark(shape: Shape, at_px: [f64; 2], turn_deg: f64, colour: Colour) -> Drawn {
        Drawn { is_part: false, ..Drawn::part(shape, at_px, turn_deg, colour) }
    }

    /// The shadow of a shape, `shade` times as light as the ground.
    pub fn shadow(shape: Shape, at_px: [f64; 2], turn_deg: f64, shade: f64) -> Drawn {
        Drawn { shade: Some(shade), ..Drawn::mark(shape, at_px, turn_deg, [0.0; 3]) }
    }
}

/// The truth about a part: the mean of its pixels and their number, by what the picture shows of it.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    pub centroid_px: [f64; 2],
    pub area_px: f64,
}

/// How a table is seen.
#[derive(Clone, Copy)]
pub struct Sight {
    pub size_px: (usize, usize),
    /// By how much of the light the darkest corner has less.
    pub fall_off: f64,
    /// Of the sensor, gray levels.
    pub noise: f64,
    /// Standard deviation of the ground's own texture, and the side of its grains in pixels.
    pub texture: (f64, usize),
    /// All light by this.
    pub exposure: f64,
    /// Levels from black to white by 255, and by how much a sample is divided when it is read back: 12 bits in a
    /// 16-bit file are 4096 levels below a sixteenth of the range.
    pub levels: f64,
    pub stored: f64,
    pub is_colour: bool,
}

impl Default for Sight {
    fn default() -> Sight {
        Sight {
            size_px: (640, 480),
            fall_off: 0.0,
            noise: 2.0,
            texture: (0.0, 1),
            exposure: 1.0,
            levels: 255.0,
            stored: 1.0,
            is_colour: false,
        }
    }
}

/// A picture of a table, and what lies on it.
pub struct DrawnTable {
    pub name: String,
    pub frame: Frame,
    pub parts: Vec<Truth>,
}

/// Draw a table.
pub fn drawn(name: &str, ground: Colour, things: &[Drawn], sight: Sight, seed: u64) -> DrawnTable {
    let (width, height) = sight.size_px;
    let random = &mut Random::of(seed, &[width as u64]);
    let (deviation, grain) = sight.texture;
    let columns = width.div_ceil(grain);
    let grains: Vec<f64> =
        (0..columns * height.div_ceil(grain)).map(|_| deviation * random.normal()).collect();
    let mut light: Vec<Colour> = (0..width * height)
        .map(|at| {
            let texture = grains[at / width / grain * columns + at % width / grain];
            ground.map(|v| v + texture)
        })
        .collect();
    let mut parts = Vec::new();
    // The last covers those before it.
    let mut seen: Vec<(usize, Vec<(usize, f64)>)> = Vec::new();
    for (number, thing) in things.iter().enumerate() {
        let covered = covered(thing, sight.size_px);
        for &(at, share) in &covered {
            let beneath = light[at];
            let own = thing.shade.map_or(thing.colour, |shade| beneath.map(|v| shade * v));
            light[at] = [0, 1, 2].map(|c| beneath[c] + share * (own[c] - beneath[c]));
        }
        if thing.is_part {
            for (_, before) in &mut seen {
                for (at, part) in before.iter_mut() {
                    if let Ok(k) = covered.binary_search_by(|(other, _)| other.cmp(at)) {
                        *part = (*part - covered[k].1).max(0.0);
                    }
                }
            }
            seen.push((number, covered));
        }
    }
    for (_, pixels) in &seen {
        let area: f64 = pixels.iter().map(|(_, part)| part).sum();
        let along =
            |of: &dyn Fn(usize) -> usize| pixels.iter().map(|(at, part)| part * of(*at) as f64).sum::<f64>();
        let centroid_px = [along(&|at| at % width) / area, along(&|at| at / width) / area];
        parts.push(Truth { centroid_px, area_px: area });
    }
    let step = 255.0 / sight.levels;
    let mut planes = [(); 3].map(|()| Vec::with_capacity(width * height));
    for (at, colour) in light.iter().enumerate() {
        let along = 0.5 * ((at % width) as f64 / width as f64 + (at / width) as f64 / height as f64);
        let shade = sight.exposure * (1.0 - sight.fall_off * along);
        let gray_noise = random.normal();
        for (plane, v) in planes.iter_mut().zip(colour) {
            let noise = if sight.is_colour { random.normal() } else { gray_noise };
            let level = (v * shade + sight.noise * noise).clamp(0.0, 255.0);
            plane.push(((level / step).round() * step / sight.stored) as f32);
        }
    }
    let planes = planes.map(|pixels| Image::new(width, height, pixels));
    let frame = if sight.is_colour {
        Frame::colour(planes)
    } else {
        let [red, ..] = planes;
        Frame::gray(red)
    };
    DrawnTable { name: name.to_owned(), frame, parts }
}

/// The pixels that a thing covers in part, in rising order, and how much of each.
fn covered(thing: &Drawn, (width, height): (usize, usize)) -> Vec<(usize, f64)> {
    let (sin, cos) = thing.turn_deg.to_radians().sin_cos();
    let [x, y] = thing.at_px;
    let reach = thing.shape.reach() + 1.0;
    let span = |at: f64, side: usize| {
        let from = (at - reach).floor().clamp(0.0, side as f64) as usize;
        from..((at + reach).ceil() + 1.0).clamp(0.0, side as f64) as usize
    };
    let mut out = Vec::new();
    for row in span(y, height) {
        for column in span(x, width) {
            let mut inside = 0;
            for point in 0..POINTS * POINTS {
                let within = |k: usize| (k as f64 + 0.5) / POINTS as f64 - 0.5;
                let dx = column as f64 + within(point % POINTS) - x;
                let dy = row as f64 + within(point / POINTS) - y;
                inside += usize::from(thing.shape.covers(cos * dx + sin * dy, cos * dy - sin * dx));
            }
            if inside > 0 {
                out.push((row * width + column, inside as f64 / (POINTS * POINTS) as f64));
            }
        }
    }
    out
}

fn gray(level: f64) -> Colour {
    [level; 3]
}

/// Places on a grid, each moved a little: things at them keep apart.
fn places(
    random: &mut Random,
    columns: usize,
    rows: usize,
    (width, height): (usize, usize),
) -> Vec<[f64; 2]> {
    let (across, down) = (width as f64 / columns as f64, height as f64 / rows as f64);
    (0..columns * rows)
        .map(|k| {
            let middle = [(k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5];
            [
                across * (middle[0] + random.uniform(-0.06, 0.06)),
                down * (middle[1] + random.uniform(-0.06, 0.06)),
            ]
        })
        .collect()
}

/// A dozen parts of mixed shapes on a grid, of one colour each.
fn mixed(random: &mut Random, colour: impl Fn(usize) -> Colour) -> Vec<Drawn> {
    let places = places(random, 4, 3, (640, 480));
    let shape = |k: usize, random: &mut Random| match k % 4 {
        0 => Shape::Disc(random.uniform(18.0, 36.0)),
        1 => Shape::Bar(random.uniform(25.0, 45.0), random.uniform(10.0, 20.0)),
        2 => Shape::Ellipse(random.uniform(30.0, 45.0), random.uniform(15.0, 25.0)),
        _ => Shape::Ring(random.uniform(28.0, 38.0), random.uniform(10.0, 16.0)),
    };
    places
        .into_iter()
        .enumerate()
        .map(|(k, at)| Drawn::part(shape(k, random), at, random.uniform(0.0, 180.0), colour(k)))
        .collect()
}

/// Every kind of table, drawn with a seed.
pub fn all(seed: u64) -> Vec<DrawnTable> {
    let random = &mut Random::of(seed, &[1]);
    let light = |k: usize| gray(150.0 + 15.0 * (k % 5) as f64);
    let dark = |k: usize| gray(30.0 + 8.0 * (k % 4) as f64);
    let mut tables = Vec::new();
    let mut add = |table| tables.push(table);
    let sight = Sight::default();

    add(drawn("light parts", gray(60.0), &mixed(random, light), sight, seed));
    add(drawn("dark parts", gray(180.0), &mixed(random, dark), sight, seed));
    add(drawn(
        "light and dark parts",
        gray(110.0),
        &mixed(random, |k| gray(if k % 2 == 0 { 190.0 } else { 40.0 })),
        sight,
        seed,
    ));

    let row = random.uniform(130.0, 190.0);
    let line = Drawn::mark(
        Shape::Bar(400.0, random.uniform(2.0, 5.0)),
        [320.0, row],
        random.uniform(-8.0, 8.0),
        gray(8.0),
    );
    let mut things = vec![line];
    things.extend(mixed(random, light));
    add(drawn("a dark line beneath", gray(60.0), &things, sight, seed));
    let line = Drawn { colour: gray(170.0), ..line };
    let mut things = vec![line];
    things.extend(mixed(random, |k| gray(if k % 2 == 0 { 200.0 } else { 30.0 })));
    add(drawn("a light line beneath", gray(100.0), &things, sight, seed));

    for breadth in [3.0, 8.0] {
        let through = random.uniform(225.0, 255.0);
        let line = Drawn::mark(
            Shape::Bar(400.0, breadth / 2.0),
            [320.0, through],
            random.uniform(-2.0, 2.0),
            gray(10.0),
        );
        let mut things = vec![line];
        things.extend(mixed(random, light));
        add(drawn(&format!("a dark line of {breadth} px beneath parts"), gray(60.0), &things, sight, seed));
    }
    for breadth in [12.0, 24.0] {
        let at_px = [random.uniform(150.0, 170.0), 240.0];
        let line = Drawn::mark(Shape::Bar(breadth / 2.0, 300.0), at_px, random.uniform(-4.0, 4.0), gray(8.0));
        let mut things = vec![line];
        things.extend(mixed(random, light));
        let name = format!("a dark line of {breadth} px on a mid-gray ground");
        add(drawn(&name, gray(110.0), &things, sight, seed));
    }
    add(drawn("nothing", gray(90.0), &[], Sight { fall_off: 0.5, ..sight }, seed));
    add(drawn("nothing on a texture of 25", gray(90.0), &[], Sight { texture: (25.0, 4), ..sight }, seed));

    let mut things = mixed(random, light);
    things[5] = Drawn::part(Shape::Bar(45.0, 45.0), things[5].at_px, random.uniform(0.0, 90.0), gray(5.0));
    add(drawn("a dark block", gray(60.0), &things, sight, seed));

    let places_165 = places(random, 15, 11, (640, 480));
    let squares: Vec<Drawn> = places_165
        .iter()
        .map(|&at| Drawn::part(Shape::Bar(8.0, 8.0), at, random.uniform(0.0, 90.0), gray(170.0)))
        .collect();
    add(drawn("165 squares of 16 px", gray(60.0), &squares, sight, seed));
    let squares: Vec<Drawn> = places_165
        .iter()
        .map(|&at| Drawn::part(Shape::Bar(2.5, 2.5), at, random.uniform(0.0, 90.0), gray(170.0)))
        .collect();
    add(drawn("165 squares of 5 px", gray(60.0), &squares, sight, seed));

    // Of the ground's brightness: 0.299 r + 0.587 g + 0.114 b = 110.
    let equal = |k: usize| match k % 4 {
        0 => [180.0, 87.0, 44.0],
        1 => [60.0, 125.0, 164.0],
        2 => [160.0, 69.0, 190.0],
        _ => [90.0, 133.0, 43.0],
    };
    let colour = Sight { is_colour: true, ..sight };
    add(drawn("equal brightness", gray(110.0), &mixed(random, equal), colour, seed));
    let faint = |k: usize| equal(k).map(|v| 110.0 + 0.35 * (v - 110.0));
    add(drawn("equal brightness, faint", gray(110.0), &mixed(random, faint), colour, seed));

    let mut pairs = Vec::new();
    for (k, [x, y]) in places(random, 3, 2, (640, 480)).into_iter().enumerate() {
        let a = random.uniform(20.0, 32.0);
        let b = a * random.uniform(0.7, 1.0);
        let (sin, cos) = random.uniform(0.0, 6.2).sin_cos();
        let (first, second, apart) = match k % 3 {
            0 => (Shape::Disc(a), Shape::Disc(b), a + b - 1.5),
            1 => (Shape::Disc(a), Shape::Bar(1.6 * b, 0.7 * b), a + 0.7 * b - 1.5),
            _ => (Shape::Ellipse(1.4 * a, 0.8 * a), Shape::Disc(b), 0.8 * a + b - 1.5),
        };
        // The second lies across the axis of the first, and is turned with it.
        let turn_deg = f64::atan2(sin, cos).to_degrees() + 90.0;
        pairs.push(Drawn::part(first, [x - 0.5 * apart * cos, y - 0.5 * apart * sin], turn_deg, gray(180.0)));
        pairs.push(Drawn::part(
            second,
            [x + 0.5 * apart * cos, y + 0.5 * apart * sin],
            turn_deg,
            gray(180.0),
        ));
    }
    add(drawn("touching pairs", gray(60.0), &pairs, sight, seed));

    let spanners: Vec<Drawn> = places(random, 3, 3, (640, 480))
        .into_iter()
        .map(|at| {
            let shape = Shape::Spanner(
                random.uniform(40.0, 60.0),
                random.uniform(5.0, 9.0),
                random.uniform(14.0, 20.0),
            );
            Drawn::part(shape, at, random.uniform(0.0, 180.0), gray(180.0))
        })
        .collect();
    add(drawn("spanners", gray(60.0), &spanners, sight, seed));

    let frame = |level| Drawn::part(Shape::Border(240.0, 200.0, 90.0), [320.0, 240.0], 0.0, gray(level));
    add(drawn("a hollow part of half the picture", gray(60.0), &[frame(180.0)], sight, seed));
    let plate = Drawn::part(Shape::Bar(245.0, 157.0), [320.0, 240.0], 2.0, gray(180.0));
    add(drawn("a plate of half the picture", gray(60.0), &[plate], sight, seed));

    let things = mixed(random, light);
    let twelve = Sight { levels: 4095.0, stored: 65535.0 / 4095.0, ..sight };
    add(drawn("12 bits in 16", gray(60.0), &things, twelve, seed));
    add(drawn("half brightness", gray(60.0), &things, Sight { exposure: 0.5, ..sight }, seed));
    add(drawn(
        "a tenth of the brightness",
        gray(60.0),
        &things,
        Sight { exposure: 0.1, noise: 0.7, ..sight },
        seed,
    ));
    for deviation in [6.0, 12.0, 18.0, 25.0] {
        let textured = Sight { texture: (deviation, 1), ..sight };
        add(drawn(
            &format!("texture of {deviation}"),
            gray(80.0),
            &mixed(random, |_| gray(190.0)),
            textured,
            seed,
        ));
    }
    let grained = Sight { texture: (12.0, 4), ..sight };
    add(drawn("texture of 12, grains of 4 px", gray(80.0), &mixed(random, |_| gray(190.0)), grained, seed));
    let grained = Sight { texture: (25.0, 4), ..sight };
    add(drawn("texture of 25, grains of 4 px", gray(80.0), &mixed(random, |_| gray(190.0)), grained, seed));
    add(drawn(
        "light falls by 70 %",
        gray(90.0),
        &mixed(random, |_| gray(230.0)),
        Sight { fall_off: 0.7, ..sight },
        seed,
    ));
    add(drawn(
        "light falls by 70 %, dark",
        gray(200.0),
        &mixed(random, |_| gray(40.0)),
        Sight { fall_off: 0.7, ..sight },
        seed,
    ));

    let shadows =
        |random: &mut Random, shapes: Vec<(Shape, [f64; 2], f64, Colour)>, shade: f64, reach: f64| {
            let (sin, cos) = random.uniform(0.0, 6.2).sin_cos();
            let mut things = Vec::new();
            for (shape, [x, y], turn_deg, _) in &shapes {
                things.push(Drawn::shadow(*shape, [x + reach * cos, y + reach * sin], *turn_deg, shade));
            }
            things
                .extend(shapes.iter().map(|&(shape, at, turn, colour)| Drawn::part(shape, at, turn, colour)));
            things
        };
    let coins: Vec<_> = places(random, 6, 4, (640, 480))
        .into_iter()
        .map(|at| (Shape::Disc(random.uniform(18.0, 30.0)), at, 0.0, gray(random.uniform(150.0, 200.0))))
        .collect();
    add(drawn(
        "coins with shadows",
        gray(100.0),
        &shadows(random, coins, 0.65, 6.0),
        Sight { fall_off: 0.4, ..sight },
        seed,
    ));
    let grains: Vec<_> = places(random, 14, 10, (640, 480))
        .into_iter()
        .map(|at| {
            let shape = Shape::Ellipse(random.uniform(9.0, 13.0), random.uniform(3.0, 4.5));
            (shape, at, random.uniform(0.0, 180.0), gray(random.uniform(150.0, 190.0)))
        })
        .collect();
    add(drawn(
        "rice with shadows",
        gray(90.0),
        &shadows(random, grains, 0.75, 2.0),
        Sight { fall_off: 0.4, ..sight },
        seed,
    ));
    let blocks: Vec<_> = mixed(random, |k| {
        [[200.0, 60.0, 50.0], [40.0, 50.0, 60.0], [230.0, 220.0, 90.0], [220.0, 220.0, 225.0]][k % 4]
    })
    .into_iter()
    .map(|thing| (thing.shape, thing.at_px, thing.turn_deg, thing.colour))
    .collect();
    add(drawn(
        "shadows on a coloured ground",
        [70.0, 130.0, 90.0],
        &shadows(random, blocks, 0.6, 9.0),
        colour,
        seed,
    ));
    tables
}
