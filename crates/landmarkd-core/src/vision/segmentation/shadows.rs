//! Shadows on the ground: darker than it by one factor in every channel, so of its hue. On a coloured ground that tells them from
//! parts. On a gray one it doesn't; there the light does, which throws all shadows to one side of their parts.

use std::f64::consts::PI;

use super::components::{Touching, components};

/// A shadow leaves at least this part of the light.
const DARKEST: f32 = 0.3;
/// A ground of fewer offsets is too dark to show shadows.
const LEAST_GROUND_OFFSETS: f32 = 3.0;
/// Colour tells a shadow if a gray part as dark would differ from it by so many offsets.
const TOLD_BY_COLOUR: f32 = 1.5;
/// A part throws a shadow if its dark pixels are at least this part of the others.
const LEAST_SHADOW: f64 = 0.04;
/// And their centroid is so far from that of the others, by the radius of a disc as large as these.
const LEAST_DISTANCE: f64 = 0.3;
/// Shadows lie to one side: of so many parts, this share of all, their mean direction is so long, and a shadow is within
/// the angle of this cosine.
const LEAST_THROWN: usize = 3;
const LEAST_SHARE: f64 = 0.6;
const LEAST_AGREEMENT: f64 = 0.9;
const LEAST_COSINE: f64 = 0.7;

/// One plane of a picture and what is known of its ground.
pub(super) struct GroundedPlane<'a> {
    pub levels: &'a [f32],
    /// By how much each pixel is above its ground.
    pub above: &'a [f32],
    /// By how much a pixel has to differ.
    pub offset: f32,
}

/// What was found about shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shadows {
    /// Shadows taken out of the foreground.
    pub left_out: usize,
    /// Parts with a dark side that may be a shadow.
    pub doubtful: usize,
}

/// A connected set of pixels that may be a shadow, or a component's pixels that aren't.
#[derive(Clone, Copy, Default)]
struct Sums {
    pixels: f64,
    x: f64,
    y: f64,
    /// Of how many offsets a gray part as dark would differ in colour.
    told: f64,
}

impl Sums {
    fn add(&mut self, x: usize, y: usize, told: f32) {
        self.pixels += 1.0;
        self.x += x as f64;
        self.y += y as f64;
        self.told += f64::from(told);
    }

    fn join(&mut self, other: &Sums) {
        self.pixels += other.pixels;
        self.x += other.x;
        self.y += other.y;
    }
}

/// Take the shadows out of a foreground. The first plane is the luminance, others are opponent ones. What throws a shadow
/// has at least `smallest_px`.
pub(super) fn take_out_shadows(
    mask: &mut [u8],
    planes: &[GroundedPlane],
    width: usize,
    smallest_px: usize,
) -> Shadows {
    let may_be: Vec<u8> =
        mask.iter().enumerate().map(|(at, &v)| u8::from(v == 1 && may_be_shadow(planes, at))).collect();
    let (dark, pieces) = components(&may_be, width, Touching::Corners);
    if pieces == 0 {
        return Shadows::default();
    }
    let (runs, count) = components(mask, width, Touching::Corners);
    let (mut parents, mut rests) = (vec![0; pieces], vec![Sums::default(); count]);
    let mut shadows = vec![Sums::default(); pieces];
    // Both lists are row by row, and each dark run is within one of the others.
    let mut dark_runs = dark.iter().peekable();
    for run in &runs {
        let rest = &mut rests[run.component()];
        let mut x = run.columns().start;
        while let Some(piece) =
            dark_runs.next_if(|dark| dark.row() == run.row() && dark.columns().start < run.columns().end)
        {
            parents[piece.component()] = run.component();
            (x..piece.columns().start).for_each(|x| rest.add(x, run.row(), 0.0));
            for column in piece.columns() {
                let told = told_by_colour(planes, run.row() * width + column);
                shadows[piece.component()].add(column, run.row(), told);
            }
            x = piece.columns().end;
        }
        (x..run.columns().end).for_each(|x| rest.add(x, run.row(), 0.0));
    }
    let by_colour = |shadow: &Sums| shadow.told >= f64::from(TOLD_BY_COLOUR) * shadow.pixels;
    // Of each component: what is dark and colour doesn't tell from a gray part.
    let mut sides = vec![Sums::default(); count];
    for (shadow, &parent) in shadows.iter().zip(&parents).filter(|(shadow, _)| !by_colour(shadow)) {
        sides[parent].join(shadow);
    }
    let thrown: Vec<Option<[f64; 2]>> = (sides.iter().zip(&rests))
        .map(|(side, rest)| {
            let (dx, dy) =
                (side.x / side.pixels - rest.x / rest.pixels, side.y / side.pixels - rest.y / rest.pixels);
            let far = dx.hypot(dy);
            let is_part = rest.pixels >= smallest_px as f64 && side.pixels <= rest.pixels;
            let is_beside = far >= LEAST_DISTANCE * (rest.pixels / PI).sqrt();
            (is_part && is_beside && side.pixels >= LEAST_SHADOW * rest.pixels)
                .then_some([dx / far, dy / far])
        })
        .collect();
    let throwing = thrown.iter().flatten().count();
    let parts = rests.iter().filter(|rest| rest.pixels >= smallest_px as f64).count();
    let direction = [0, 1]
        .map(|axis| thrown.iter().flatten().map(|along| along[axis]).sum::<f64>() / throwing.max(1) as f64);
    let length = direction[0].hypot(direction[1]);
    let is_one_light = throwing >= LEAST_THROWN
        && throwing as f64 >= LEAST_SHARE * parts as f64
        && length >= LEAST_AGREEMENT;
    let is_thrown = |parent: usize| {
        let along = thrown[parent].map(|[x, y]| (x * direction[0] + y * direction[1]) / length);
        is_one_light && along.is_some_and(|cosine| cosine >= LEAST_COSINE)
    };
    let is_shadow: Vec<bool> = shadows
        .iter()
        .zip(&parents)
        .map(|(shadow, &parent)| by_colour(shadow) || is_thrown(parent))
        .collect();
    for run in dark.iter().filter(|run| is_shadow[run.component()]) {
        mask[run.row() * width..][run.columns()].fill(0);
    }
    let doubtful =
        thrown.iter().enumerate().filter(|(parent, side)| side.is_some() && !is_thrown(*parent)).count();
    let mut shadowed: Vec<usize> =
        parents.iter().zip(&is_shadow).filter(|(_, is)| **is).map(|(parent, _)| *parent).collect();
    shadowed.sort_unstable();
    shadowed.dedup();
    Shadows { left_out: shadowed.len(), doubtful }
}

/// Whether a pixel is darker than its ground by one factor in every channel.
fn may_be_shadow(planes: &[GroundedPlane], at: usize) -> bool {
    let GroundedPlane { levels, above, offset } = planes[0];
    let ground = levels[at] - above[at];
    if above[at] > -offset || ground < LEAST_GROUND_OFFSETS * offset || levels[at] < DARKEST * ground {
        return false;
    }
    let lost = above[at] / ground;
    planes[1..].iter().all(|plane| {
        let expected = lost * (plane.levels[at] - plane.above[at]);
        (plane.above[at] - expected).abs() <= plane.offset
    })
}

/// By how many offsets a gray part as dark as a pixel would differ from it in colour.
fn told_by_colour(planes: &[GroundedPlane], at: usize) -> f32 {
    let levels = planes[1..].iter().map(|plane| plane.levels[at].abs() / plane.offset);
    levels.fold(0.0, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 240;

    /// A ground of a colour with discs on it, and how the levels of a pixel differ: red, green and blue.
    fn seen(ground: [f32; 3], thing: impl Fn(f64, f64) -> Option<[f32; 3]>) -> (Vec<u8>, Shadows, Vec<u8>) {
        let colours: Vec<[f32; 3]> = (0..WIDTH * 160)
            .map(|at| thing((at % WIDTH) as f64, (at / WIDTH) as f64).unwrap_or(ground))
            .collect();
        let plane = |of: &dyn Fn([f32; 3]) -> f32| {
            let levels: Vec<f32> = colours.iter().map(|&colour| of(colour)).collect();
            let above: Vec<f32> = levels.iter().map(|v| v - of(ground)).collect();
            (levels, above)
        };
        let planes = [
            plane(&|[r, g, b]| 0.299 * r + 0.587 * g + 0.114 * b),
            plane(&|[r, g, _]| r - g),
            plane(&|[r, g, b]| b - (r + g) / 2.0),
        ];
        let grounded: Vec<GroundedPlane> =
            planes.iter().map(|(levels, above)| GroundedPlane { levels, above, offset: 6.0 }).collect();
        let whole: Vec<u8> = colours.iter().map(|colour| u8::from(*colour != ground)).collect();
        let mut mask = whole.clone();
        let shadows = take_out_shadows(&mut mask, &grounded, WIDTH, 12);
        (whole, shadows, mask)
    }

    fn is_in(x: f64, y: f64, at: [f64; 2]) -> bool {
        (x - at[0]).hypot(y - at[1]) < 20.0
    }

    const GREEN: [f32; 3] = [70.0, 140.0, 90.0];

    #[test]
    fn on_a_coloured_ground_a_shadow_has_its_hue_and_a_gray_part_has_not() {
        let shade = GREEN.map(|v| 0.6 * v);
        let (whole, shadows, mask) = seen(GREEN, |x, y| match () {
            () if is_in(x, y, [60.0, 60.0]) => Some([210.0, 60.0, 60.0]),
            () if is_in(x, y, [68.0, 66.0]) => Some(shade),
            () if is_in(x, y, [160.0, 90.0]) => Some([64.0; 3]),
            () => None,
        });
        assert_eq!(shadows, Shadows { left_out: 1, doubtful: 0 });
        for at in 0..mask.len() {
            let (x, y) = ((at % WIDTH) as f64, (at / WIDTH) as f64);
            let is_part = is_in(x, y, [60.0, 60.0]) || is_in(x, y, [160.0, 90.0]);
            assert_eq!(mask[at] == 1, is_part && whole[at] == 1, "({x}, {y})");
        }
    }

    /// Light discs, each with a dark side towards a direction of its own.
    fn discs(towards: [[f64; 2]; 4]) -> (usize, Shadows) {
        let places = [[50.0, 45.0], [170.0, 50.0], [60.0, 115.0], [180.0, 110.0]];
        let (_, shadows, mask) = seen([120.0; 3], |x, y| {
            let near = places.iter().zip(&towards);
            let mut beside = near.clone().filter(|(at, to)| is_in(x, y, [at[0] + to[0], at[1] + to[1]]));
            if places.iter().any(|at| is_in(x, y, *at)) {
                return Some([200.0; 3]);
            }
            beside.next().map(|_| [80.0; 3])
        });
        (mask.iter().map(|&v| usize::from(v)).sum(), shadows)
    }

    #[test]
    fn on_a_gray_ground_shadows_lie_to_one_side() {
        let (area, shadows) = discs([[6.0, 4.0]; 4]);
        assert_eq!(shadows, Shadows { left_out: 4, doubtful: 0 });
        let disc = (0..60 * 60).filter(|at| is_in((at % 60) as f64, (at / 60) as f64, [30.0, 30.0])).count();
        assert_eq!(area, 4 * disc);
        let (all, shadows) = discs([[6.0, 4.0], [-6.0, 4.0], [0.0, -7.0], [-6.0, -4.0]]);
        assert_eq!(shadows, Shadows { left_out: 0, doubtful: 4 });
        assert!(all > area);
    }
}
