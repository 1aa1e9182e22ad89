//! Eight objects, and the clutter that they get lost in. Scene units are pixels of a 192 × 192 picture; an object's
//! centre is (0, 0), and nothing is painted around it.

use super::drawing::{Colour, Paint, Scene, hash};

const WHITE: Colour = [240.0, 238.0, 230.0];
const BLACK: Colour = [30.0, 29.0, 32.0];
const STEEL: Colour = [150.0, 156.0, 164.0];
const CARD: Colour = [196.0, 156.0, 108.0];
const WOOD: Colour = [170.0, 112.0, 60.0];
const RED: Colour = [192.0, 50.0, 44.0];
const BLUE: Colour = [40.0, 84.0, 160.0];
const GREEN: Colour = [60.0, 130.0, 72.0];
const YELLOW: Colour = [234.0, 192.0, 60.0];

/// The names and scenes of the objects.
pub fn objects() -> Vec<(&'static str, Scene)> {
    vec![
        ("mug", mug()),
        ("radio", radio()),
        ("clock", clock()),
        ("dice", dice()),
        ("parcel", parcel()),
        ("robot", robot()),
        ("phone", phone()),
        ("tin", tin()),
    ]
}

/// The plain ground on which an object is learned.
pub fn table() -> Scene {
    Scene::on([118.0, 122.0, 126.0])
}

/// A ground full of things that are none of the objects; another for each seed.
pub fn clutter(seed: u32) -> Scene {
    let ground = [60.0, 80.0, 70.0].map(|c| c + 70.0 * hash(seed, c as i32, 0));
    let mut scene = Scene::on(Paint::Clouds { colours: [ground.map(|c| 0.7 * c), ground], size: 17.0, seed });
    for n in 0..26 {
        let part = |salt: u32| hash(seed + 7 * salt, n, 1);
        let place = (240.0 * part(0) - 120.0, 240.0 * part(1) - 120.0);
        let (turn_deg, half) = (360.0 * part(11), [7.0 + 24.0 * part(2), 6.0 + 20.0 * part(3)]);
        let colours =
            [[part(4), part(5), part(6)], [part(7), part(8), part(9)]].map(|c| c.map(|v| 20.0 + 220.0 * v));
        let paint = match n % 5 {
            0 => Paint::Stripes { colours, period: 8.0 + 10.0 * part(10) },
            1 => Paint::Mosaic { colours, size: 8.0 + 6.0 * part(10), seed: seed + n as u32 },
            _ => Paint::Plain(colours[0]),
        };
        match n % 4 {
            0 => scene.ellipse(place, turn_deg, half, paint),
            1 => scene.triangle(place, turn_deg, half, paint),
            _ => scene.turned_rectangle(place, turn_deg, half, paint),
        }
    }
    scene
}

fn mug() -> Scene {
    let mut scene = Scene::default();
    scene.ring((46.0, 4.0), 26.0, 16.0, BLUE);
    scene.trapezium((-6.0, 2.0), 0.0, [46.0, 40.0, 52.0], BLUE);
    scene.ellipse((-6.0, -50.0), 0.0, [46.0, 11.0], WHITE);
    scene.ellipse((-6.0, -49.0), 0.0, [40.0, 8.0], [70.0, 44.0, 28.0]);
    scene.rectangle(-48.0, -22.0, 83.0, 10.0, Paint::Chequers { colours: [WHITE, RED], size: 5.0 });
    scene.rectangle(-46.0, 32.0, 79.0, 7.0, YELLOW);
    scene.triangle((-6.0, 10.0), 0.0, [20.0, 17.0], YELLOW);
    scene.triangle((-6.0, 16.0), 180.0, [10.0, 8.0], RED);
    scene.disc(-34.0, 4.0, 6.0, WHITE);
    scene.disc(22.0, 4.0, 6.0, WHITE);
    scene
}

fn radio() -> Scene {
    let mut scene = Scene::default();
    scene.turned_rectangle((58.0, -62.0), 20.0, [1.8, 30.0], STEEL);
    scene.rectangle(-70.0, -42.0, 140.0, 88.0, WOOD);
    scene.rectangle(-62.0, -34.0, 124.0, 72.0, [92.0, 60.0, 36.0]);
    scene.disc(-28.0, 4.0, 30.0, BLACK);
    scene.disc(-28.0, 4.0, 26.0, Paint::Dots { colours: [[80.0, 78.0, 76.0], WHITE], size: 8.0, seed: 300 });
    scene.rectangle(12.0, -30.0, 46.0, 20.0, YELLOW);
    scene.rectangle(40.0, -30.0, 2.5, 20.0, RED);
    for mark in 0..8 {
        let height = if mark % 3 == 0 { 9.0 } else { 5.0 };
        scene.rectangle(15.0 + 5.4 * mark as f32, -29.0, 1.5, height, BLACK);
    }
    for (x, turn) in [(24.0, 30.0), (48.0, -60.0)] {
        scene.disc(x, 6.0, 9.0, STEEL);
        scene.turned_rectangle((x, 6.0), turn, [1.5, 8.0], BLACK);
    }
    for button in 0..4 {
        let colour = [RED, WHITE, WHITE, GREEN][button];
        scene.rectangle(14.0 + 12.0 * button as f32, 22.0, 9.0, 9.0, colour);
    }
    scene
}

fn clock() -> Scene {
    let mut scene = Scene::default();
    scene.ellipse((-36.0, -50.0), -40.0, [20.0, 12.0], RED);
    scene.ellipse((36.0, -50.0), 40.0, [20.0, 12.0], RED);
    scene.turned_rectangle((-34.0, 58.0), 30.0, [4.0, 13.0], BLACK);
    scene.turned_rectangle((34.0, 58.0), -30.0, [4.0, 13.0], BLACK);
    scene.disc(0.0, 4.0, 60.0, RED);
    scene.disc(0.0, 4.0, 51.0, WHITE);
    for hour in 0..12 {
        let turn = 30.0 * hour as f32;
        let (sin, cos) = turn.to_radians().sin_cos();
        let half = if hour % 3 == 0 { [3.5, 8.0] } else { [1.6, 5.0] };
        scene.turned_rectangle((42.0 * sin, 4.0 - 42.0 * cos), turn, half, BLACK);
    }
    scene.turned_rectangle((11.0, -5.0), 50.0, [3.0, 15.0], BLACK);
    scene.turned_rectangle((-14.0, -6.0), -55.0, [2.2, 20.0], BLACK);
    scene.disc(0.0, 4.0, 5.0, RED);
    scene.rectangle(-12.0, 20.0, 24.0, 12.0, BLUE);
    scene.rectangle(-8.0, 23.0, 5.0, 6.0, WHITE);
    scene.rectangle(2.0, 23.0, 7.0, 6.0, WHITE);
    scene
}

/// A die beside another: five and three, one of them turned.
fn dice() -> Scene {
    let mut scene = Scene::default();
    for (x, y, turn, pips, colour, ink) in [
        (-26.0_f32, -18.0_f32, 12.0_f32, &[(-1, -1), (1, -1), (0, 0), (-1, 1), (1, 1)][..], WHITE, BLACK),
        (30.0, 28.0, -28.0, &[(-1, -1), (0, 0), (1, 1)][..], RED, WHITE),
        (40.0, -42.0, 40.0, &[(-1, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (1, 1)][..], BLUE, YELLOW),
    ] {
        let half = if pips.len() == 6 { 20.0 } else { 32.0 };
        scene.turned_rectangle((x, y), turn, [half, half], colour);
        let (sin, cos) = turn.to_radians().sin_cos();
        for &(column, row) in pips {
            let (dx, dy) = (0.56 * half * column as f32, 0.56 * half * row as f32);
            scene.disc(x + cos * dx - sin * dy, y + sin * dx + cos * dy, 0.19 * half, ink);
        }
    }
    scene
}

fn parcel() -> Scene {
    let mut scene = Scene::default();
    scene.rectangle(-66.0, -52.0, 132.0, 104.0, CARD);
    scene.rectangle(-66.0, -8.0, 132.0, 14.0, [222.0, 190.0, 140.0]);
    scene.rectangle(-58.0, 12.0, 62.0, 34.0, WHITE);
    for line in 0..4 {
        let length = 30.0 + 24.0 * hash(310, line, 0);
        scene.rectangle(-54.0, 16.0 + 7.5 * line as f32, length, 3.0, BLACK);
    }
    let mut x = 16.0;
    for bar in 0..14 {
        let width = 1.2 + 2.6 * hash(311, bar, 0);
        scene.rectangle(x, 14.0, width, 28.0, BLACK);
        x += width + 1.2;
    }
    // stamps; two arrows up
    scene.rectangle(30.0, -46.0, 28.0, 32.0, WHITE);
    scene.rectangle(33.0, -43.0, 22.0, 26.0, GREEN);
    scene.disc(44.0, -30.0, 7.0, YELLOW);
    scene.rectangle(4.0, -44.0, 22.0, 26.0, Paint::Mosaic { colours: [BLUE, WHITE], size: 7.0, seed: 312 });
    for x in [-50.0, -24.0] {
        scene.triangle((x, -38.0), 0.0, [10.0, 8.0], RED);
        scene.rectangle(x - 3.5, -30.0, 7.0, 16.0, RED);
    }
    scene
}

fn robot() -> Scene {
    let mut scene = Scene::default();
    scene.rectangle(-2.0, -78.0, 4.0, 16.0, BLACK);
    scene.disc(0.0, -78.0, 6.0, RED);
    scene.rectangle(-30.0, -64.0, 60.0, 44.0, STEEL);
    scene.disc(-13.0, -46.0, 9.0, YELLOW);
    scene.disc(13.0, -46.0, 9.0, YELLOW);
    scene.disc(-12.0, -46.0, 4.0, BLACK);
    scene.disc(14.0, -46.0, 4.0, BLACK);
    scene.rectangle(-16.0, -32.0, 32.0, 6.0, Paint::Stripes { colours: [BLACK, WHITE], period: 5.0 });
    scene.rectangle(-8.0, -20.0, 16.0, 6.0, BLACK);
    scene.rectangle(-38.0, -14.0, 76.0, 54.0, GREEN);
    scene.rectangle(-28.0, -6.0, 34.0, 24.0, BLACK);
    for cell in 0..12 {
        let lit = hash(320, cell, 0) > 0.4;
        let (left, top) = (-25.0 + 8.0 * (cell % 4) as f32, -3.0 + 7.0 * (cell / 4) as f32);
        scene.rectangle(left, top, 5.0, 4.5, if lit { [120.0, 230.0, 130.0] } else { [50.0, 80.0, 56.0] });
    }
    for (n, y) in [-2.0, 12.0, 26.0].into_iter().enumerate() {
        scene.disc(22.0, y, 5.5, [RED, YELLOW, WHITE][n]);
    }
    for (side, lift) in [(-1.0_f32, 26.0_f32), (1.0, -34.0)] {
        scene.turned_rectangle((52.0 * side, 2.0), lift, [6.0, 24.0], STEEL);
        scene.rectangle(15.0 * side - 9.0, 40.0, 18.0, 26.0, BLUE);
        scene.rectangle(18.0 * side - 14.0, 64.0, 28.0, 10.0, BLACK);
    }
    scene
}

fn phone() -> Scene {
    let mut scene = Scene::default();
    scene.trapezium((0.0, 14.0), 0.0, [44.0, 66.0, 46.0], [46.0, 92.0, 84.0]);
    scene.turned_rectangle((0.0, -46.0), 0.0, [68.0, 12.0], BLACK);
    scene.ellipse((-56.0, -36.0), 0.0, [18.0, 15.0], BLACK);
    scene.ellipse((56.0, -36.0), 0.0, [18.0, 15.0], BLACK);
    scene.disc(0.0, 16.0, 36.0, WHITE);
    scene.disc(0.0, 16.0, 13.0, RED);
    scene.rectangle(-7.0, 13.0, 14.0, 6.0, WHITE);
    for finger in 0..10 {
        let (sin, cos) = (30.0 * finger as f32 - 60.0).to_radians().sin_cos();
        scene.disc(25.0 * sin, 16.0 - 25.0 * cos, 5.0, BLACK);
    }
    scene.rectangle(20.0, 48.0, 34.0, 9.0, YELLOW);
    scene.rectangle(-54.0, 48.0, 20.0, 9.0, WHITE);
    scene
}

fn tin() -> Scene {
    let mut scene = Scene::default();
    scene.rectangle(-44.0, -66.0, 88.0, 134.0, RED);
    scene.ellipse((0.0, -66.0), 0.0, [44.0, 10.0], STEEL);
    scene.ring((8.0, -67.0), 7.0, 3.5, BLACK);
    scene.ellipse((0.0, 68.0), 0.0, [44.0, 9.0], RED);
    scene.rectangle(-44.0, -44.0, 88.0, 24.0, WHITE);
    let paint = Paint::Writing { colours: [WHITE, BLUE], size: 15.0, seed: 330 };
    scene.rectangle(-36.0, -40.0, 72.0, 16.0, paint);
    scene.disc(-16.0, 14.0, 19.0, YELLOW);
    scene.disc(16.0, 22.0, 15.0, [236.0, 140.0, 40.0]);
    scene.ellipse((2.0, -6.0), 40.0, [5.0, 15.0], GREEN);
    scene.ellipse((-10.0, -8.0), -50.0, [5.0, 13.0], GREEN);
    scene.rectangle(-44.0, 46.0, 88.0, 12.0, Paint::Stripes { colours: [WHITE, GREEN], period: 11.0 });
    scene
}
