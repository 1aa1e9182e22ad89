//! Eight objects, and the clutter that they get lost in. Scene units are pixels of a 192 × 192 picture; an object's
//! centre is (0, 0), and nothing is painted around it.

use super::drawing::{Colour, Outline, Paint, Scene, hash};

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
    Scene::on(Paint::Plain([118.0, 122.0, 126.0]))
}

/// A ground full of things that are none of the objects; another for each seed.
pub fn clutter(seed: u32) -> Scene {
    let ground = [60.0, 80.0, 70.0].map(|c| c + 70.0 * hash(seed, c as i32, 0));
    let mut scene = Scene::on(Paint::Clouds { colours: [ground.map(|c| 0.7 * c), ground], size: 17.0, seed });
    for n in 0..26 {
        let part = |salt: u32| hash(seed + 7 * salt, n, 1);
        let place = (240.0 * part(0) - 120.0, 240.0 * part(1) - 120.0);
        let (half_width, half_height) = (7.0 + 24.0 * part(2), 6.0 + 20.0 * part(3));
        let colours =
            [[part(4), part(5), part(6)], [part(7), part(8), part(9)]].map(|c| c.map(|v| 20.0 + 220.0 * v));
        let outline = match n % 4 {
            0 => Outline::Ellipse { half_width, half_height },
            1 => Outline::Triangle { half_width, half_height },
            _ => Outline::Rectangle { half_width, half_height },
        };
        let paint = match n % 5 {
            0 => Paint::Stripes { colours, period: 8.0 + 10.0 * part(10) },
            1 => Paint::Mosaic { colours, size: 8.0 + 6.0 * part(10), seed: seed + n as u32 },
            _ => Paint::Plain(colours[0]),
        };
        scene = scene.shape(place, 360.0 * part(11), outline, paint);
    }
    scene
}

fn plain(colour: Colour) -> Paint {
    Paint::Plain(colour)
}

fn mug() -> Scene {
    Scene::default()
        .shape((46.0, 4.0), 0.0, Outline::Ring { outer: 26.0, inner: 16.0 }, plain(BLUE))
        .shape(
            (-6.0, 2.0),
            0.0,
            Outline::Trapezium { half_top: 46.0, half_bottom: 40.0, half_height: 52.0 },
            plain(BLUE),
        )
        .shape((-6.0, -50.0), 0.0, Outline::Ellipse { half_width: 46.0, half_height: 11.0 }, plain(WHITE))
        .shape(
            (-6.0, -49.0),
            0.0,
            Outline::Ellipse { half_width: 40.0, half_height: 8.0 },
            plain([70.0, 44.0, 28.0]),
        )
        .rectangle(-48.0, -22.0, 83.0, 10.0, Paint::Chequers { colours: [WHITE, RED], size: 5.0 })
        .rectangle(-46.0, 32.0, 79.0, 7.0, plain(YELLOW))
        .shape((-6.0, 10.0), 0.0, Outline::Triangle { half_width: 20.0, half_height: 17.0 }, plain(YELLOW))
        .shape((-6.0, 16.0), 180.0, Outline::Triangle { half_width: 10.0, half_height: 8.0 }, plain(RED))
        .disc(-34.0, 4.0, 6.0, plain(WHITE))
        .disc(22.0, 4.0, 6.0, plain(WHITE))
}

fn radio() -> Scene {
    let mut scene = Scene::default()
        .shape((58.0, -62.0), 20.0, Outline::Rectangle { half_width: 1.8, half_height: 30.0 }, plain(STEEL))
        .rectangle(-70.0, -42.0, 140.0, 88.0, plain(WOOD))
        .rectangle(-62.0, -34.0, 124.0, 72.0, plain([92.0, 60.0, 36.0]))
        .disc(-28.0, 4.0, 30.0, plain(BLACK))
        .disc(-28.0, 4.0, 26.0, Paint::Dots { colours: [[80.0, 78.0, 76.0], WHITE], size: 8.0, seed: 300 })
        .rectangle(12.0, -30.0, 46.0, 20.0, plain(YELLOW))
        .rectangle(40.0, -30.0, 2.5, 20.0, plain(RED));
    for mark in 0..8 {
        let height = if mark % 3 == 0 { 9.0 } else { 5.0 };
        scene = scene.rectangle(15.0 + 5.4 * mark as f32, -29.0, 1.5, height, plain(BLACK));
    }
    for (x, turn) in [(24.0, 30.0), (48.0, -60.0)] {
        scene = scene.disc(x, 6.0, 9.0, plain(STEEL)).shape(
            (x, 6.0),
            turn,
            Outline::Rectangle { half_width: 1.5, half_height: 8.0 },
            plain(BLACK),
        );
    }
    for button in 0..4 {
        let colour = [RED, WHITE, WHITE, GREEN][button];
        scene = scene.rectangle(14.0 + 12.0 * button as f32, 22.0, 9.0, 9.0, plain(colour));
    }
    scene
}

fn clock() -> Scene {
    let mut scene = Scene::default()
        .shape((-36.0, -50.0), -40.0, Outline::Ellipse { half_width: 20.0, half_height: 12.0 }, plain(RED))
        .shape((36.0, -50.0), 40.0, Outline::Ellipse { half_width: 20.0, half_height: 12.0 }, plain(RED))
        .shape((-34.0, 58.0), 30.0, Outline::Rectangle { half_width: 4.0, half_height: 13.0 }, plain(BLACK))
        .shape((34.0, 58.0), -30.0, Outline::Rectangle { half_width: 4.0, half_height: 13.0 }, plain(BLACK))
        .disc(0.0, 4.0, 60.0, plain(RED))
        .disc(0.0, 4.0, 51.0, plain(WHITE));
    for hour in 0..12 {
        let turn = 30.0 * hour as f32;
        let (sin, cos) = turn.to_radians().sin_cos();
        let (half_width, half_height) = if hour % 3 == 0 { (3.5, 8.0) } else { (1.6, 5.0) };
        let place = (42.0 * sin, 4.0 - 42.0 * cos);
        scene = scene.shape(place, turn, Outline::Rectangle { half_width, half_height }, plain(BLACK));
    }
    scene
        .shape((11.0, -5.0), 50.0, Outline::Rectangle { half_width: 3.0, half_height: 15.0 }, plain(BLACK))
        .shape((-14.0, -6.0), -55.0, Outline::Rectangle { half_width: 2.2, half_height: 20.0 }, plain(BLACK))
        .disc(0.0, 4.0, 5.0, plain(RED))
        .rectangle(-12.0, 20.0, 24.0, 12.0, plain(BLUE))
        .rectangle(-8.0, 23.0, 5.0, 6.0, plain(WHITE))
        .rectangle(2.0, 23.0, 7.0, 6.0, plain(WHITE))
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
        let outline = Outline::Rectangle { half_width: half, half_height: half };
        scene = scene.shape((x, y), turn, outline, plain(colour));
        let (sin, cos) = turn.to_radians().sin_cos();
        for &(column, row) in pips {
            let (dx, dy) = (0.56 * half * column as f32, 0.56 * half * row as f32);
            scene = scene.disc(x + cos * dx - sin * dy, y + sin * dx + cos * dy, 0.19 * half, plain(ink));
        }
    }
    scene
}

fn parcel() -> Scene {
    let mut scene = Scene::default()
        .rectangle(-66.0, -52.0, 132.0, 104.0, plain(CARD))
        .rectangle(-66.0, -8.0, 132.0, 14.0, plain([222.0, 190.0, 140.0]))
        .rectangle(-58.0, 12.0, 62.0, 34.0, plain(WHITE));
    for line in 0..4 {
        let length = 30.0 + 24.0 * hash(310, line, 0);
        scene = scene.rectangle(-54.0, 16.0 + 7.5 * line as f32, length, 3.0, plain(BLACK));
    }
    let mut x = 16.0;
    for bar in 0..14 {
        let width = 1.2 + 2.6 * hash(311, bar, 0);
        scene = scene.rectangle(x, 14.0, width, 28.0, plain(BLACK));
        x += width + 1.2;
    }
    // stamps; two arrows up
    scene = scene
        .rectangle(30.0, -46.0, 28.0, 32.0, plain(WHITE))
        .rectangle(33.0, -43.0, 22.0, 26.0, plain(GREEN))
        .disc(44.0, -30.0, 7.0, plain(YELLOW))
        .rectangle(4.0, -44.0, 22.0, 26.0, Paint::Mosaic { colours: [BLUE, WHITE], size: 7.0, seed: 312 });
    for x in [-50.0, -24.0] {
        scene = scene
            .shape((x, -38.0), 0.0, Outline::Triangle { half_width: 10.0, half_height: 8.0 }, plain(RED))
            .rectangle(x - 3.5, -30.0, 7.0, 16.0, plain(RED));
    }
    scene
}

fn robot() -> Scene {
    let mut scene = Scene::default()
        .rectangle(-2.0, -78.0, 4.0, 16.0, plain(BLACK))
        .disc(0.0, -78.0, 6.0, plain(RED))
        .rectangle(-30.0, -64.0, 60.0, 44.0, plain(STEEL))
        .disc(-13.0, -46.0, 9.0, plain(YELLOW))
        .disc(13.0, -46.0, 9.0, plain(YELLOW))
        .disc(-12.0, -46.0, 4.0, plain(BLACK))
        .disc(14.0, -46.0, 4.0, plain(BLACK))
        .rectangle(-16.0, -32.0, 32.0, 6.0, Paint::Stripes { colours: [BLACK, WHITE], period: 5.0 })
        .rectangle(-8.0, -20.0, 16.0, 6.0, plain(BLACK))
        .rectangle(-38.0, -14.0, 76.0, 54.0, plain(GREEN))
        .rectangle(-28.0, -6.0, 34.0, 24.0, plain(BLACK));
    for cell in 0..12 {
        let lit = hash(320, cell, 0) > 0.4;
        let (left, top) = (-25.0 + 8.0 * (cell % 4) as f32, -3.0 + 7.0 * (cell / 4) as f32);
        scene = scene.rectangle(
            left,
            top,
            5.0,
            4.5,
            plain(if lit { [120.0, 230.0, 130.0] } else { [50.0, 80.0, 56.0] }),
        );
    }
    for (n, y) in [-2.0, 12.0, 26.0].into_iter().enumerate() {
        scene = scene.disc(22.0, y, 5.5, plain([RED, YELLOW, WHITE][n]));
    }
    for (side, lift) in [(-1.0_f32, 26.0_f32), (1.0, -34.0)] {
        scene = scene
            .shape(
                (52.0 * side, 2.0),
                lift,
                Outline::Rectangle { half_width: 6.0, half_height: 24.0 },
                plain(STEEL),
            )
            .rectangle(15.0 * side - 9.0, 40.0, 18.0, 26.0, plain(BLUE))
            .rectangle(18.0 * side - 14.0, 64.0, 28.0, 10.0, plain(BLACK));
    }
    scene
}

fn phone() -> Scene {
    let mut scene = Scene::default()
        .shape(
            (0.0, 14.0),
            0.0,
            Outline::Trapezium { half_top: 44.0, half_bottom: 66.0, half_height: 46.0 },
            plain([46.0, 92.0, 84.0]),
        )
        .shape((0.0, -46.0), 0.0, Outline::Rectangle { half_width: 68.0, half_height: 12.0 }, plain(BLACK))
        .shape((-56.0, -36.0), 0.0, Outline::Ellipse { half_width: 18.0, half_height: 15.0 }, plain(BLACK))
        .shape((56.0, -36.0), 0.0, Outline::Ellipse { half_width: 18.0, half_height: 15.0 }, plain(BLACK))
        .disc(0.0, 16.0, 36.0, plain(WHITE))
        .disc(0.0, 16.0, 13.0, plain(RED))
        .rectangle(-7.0, 13.0, 14.0, 6.0, plain(WHITE));
    for finger in 0..10 {
        let (sin, cos) = (30.0 * finger as f32 - 60.0).to_radians().sin_cos();
        scene = scene.disc(25.0 * sin, 16.0 - 25.0 * cos, 5.0, plain(BLACK));
    }
    scene.rectangle(20.0, 48.0, 34.0, 9.0, plain(YELLOW)).rectangle(-54.0, 48.0, 20.0, 9.0, plain(WHITE))
}

fn tin() -> Scene {
    Scene::default()
        .rectangle(-44.0, -66.0, 88.0, 134.0, plain(RED))
        .shape((0.0, -66.0), 0.0, Outline::Ellipse { half_width: 44.0, half_height: 10.0 }, plain(STEEL))
        .shape((8.0, -67.0), 0.0, Outline::Ring { outer: 7.0, inner: 3.5 }, plain(BLACK))
        .shape((0.0, 68.0), 0.0, Outline::Ellipse { half_width: 44.0, half_height: 9.0 }, plain(RED))
        .rectangle(-44.0, -44.0, 88.0, 24.0, plain(WHITE))
        .rectangle(-36.0, -40.0, 72.0, 16.0, Paint::Writing { colours: [WHITE, BLUE], size: 15.0, seed: 330 })
        .disc(-16.0, 14.0, 19.0, plain(YELLOW))
        .disc(16.0, 22.0, 15.0, plain([236.0, 140.0, 40.0]))
        .shape((2.0, -6.0), 40.0, Outline::Ellipse { half_width: 5.0, half_height: 15.0 }, plain(GREEN))
        .shape((-10.0, -8.0), -50.0, Outline::Ellipse { half_width: 5.0, half_height: 13.0 }, plain(GREEN))
        .rectangle(-44.0, 46.0, 88.0, 12.0, Paint::Stripes { colours: [WHITE, GREEN], period: 11.0 })
}
