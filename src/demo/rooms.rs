//! Eight rooms: a wall and a floor, and what stands and hangs there. Scene units are pixels of a 320 × 240 picture
//! whose top-left corner is (0, 0); walls and floors go on beyond it, for views from elsewhere.

use super::drawing::{Colour, Paint, Scene, hash};

const WHITE: Colour = [240.0, 238.0, 230.0];
const CREAM: Colour = [226.0, 212.0, 182.0];
const BLACK: Colour = [28.0, 27.0, 30.0];
const STEEL: Colour = [132.0, 140.0, 150.0];
const OAK: Colour = [158.0, 112.0, 66.0];
const WALNUT: Colour = [84.0, 56.0, 38.0];
const SKY: Colour = [150.0, 196.0, 232.0];
const LEAF: Colour = [62.0, 118.0, 58.0];
const RED: Colour = [186.0, 52.0, 44.0];
const BLUE: Colour = [42.0, 78.0, 146.0];
const YELLOW: Colour = [232.0, 190.0, 60.0];

/// The names and scenes of the rooms.
pub fn rooms() -> Vec<(&'static str, Scene)> {
    vec![
        ("kitchen", kitchen()),
        ("office", office()),
        ("library", library()),
        ("workshop", workshop()),
        ("hallway", hallway()),
        ("laboratory", laboratory()),
        ("bedroom", bedroom()),
        ("storeroom", storeroom()),
    ]
}

fn shade(colour: Colour, by: f32) -> Colour {
    colour.map(|c| c * by)
}

/// A wall down to `floor_y`, a skirting board, a floor.
fn room(wall: Paint, floor: Paint, floor_y: f32) -> Scene {
    let mut scene = Scene::on(wall);
    scene.rectangle(-2000.0, floor_y, 4000.0, 2000.0, floor);
    scene.rectangle(-2000.0, floor_y - 6.0, 4000.0, 6.0, shade(WHITE, 0.85));
    scene
}

fn wall(colour: Colour, seed: u32) -> Paint {
    Paint::Clouds { colours: [shade(colour, 0.93), colour], size: 38.0, seed }
}

/// A picture in a frame of 4 px; left, top, width and height are those of the picture.
fn framed(scene: &mut Scene, [left, top, width, height]: [f32; 4], frame: Colour, picture: impl Into<Paint>) {
    scene.rectangle(left - 4.0, top - 4.0, width + 8.0, height + 8.0, frame);
    scene.rectangle(left, top, width, height, picture);
}

/// A window with a cross and what is seen through it.
fn window(scene: &mut Scene, [left, top, width, height]: [f32; 4], seed: u32) {
    let view = Paint::Clouds { colours: [WHITE, SKY], size: 22.0, seed };
    let hills = Paint::Mosaic { colours: [shade(LEAF, 0.6), LEAF], size: 9.0, seed };
    framed(scene, [left, top, width, height], WHITE, view);
    scene.rectangle(left, top + 0.68 * height, width, 0.32 * height, hills);
    scene.rectangle(left + width / 2.0 - 2.0, top, 4.0, height, WHITE);
    scene.rectangle(left, top + 0.45 * height - 2.0, width, 4.0, WHITE);
}

/// A row of books of hashed widths, heights and colours, standing on `bottom`.
fn books(scene: &mut Scene, left: f32, right: f32, bottom: f32, height: f32, seed: u32) {
    let mut x = left;
    for n in 0.. {
        let part = |salt: u32| hash(seed + salt, n, 0);
        let width = 6.0 + 8.0 * part(0);
        if x + width > right {
            return;
        }
        let tall = height * (0.68 + 0.3 * part(1));
        let colour = [part(2), part(3), part(4)].map(|c| 40.0 + 190.0 * c);
        let top = bottom - tall;
        scene.rectangle(x, top, width - 1.0, tall, colour);
        match n % 3 {
            0 => scene.rectangle(x, top + 0.15 * tall, width - 1.0, 0.12 * tall, CREAM),
            1 => scene.rectangle(x + 2.0, top + 0.3 * tall, width - 5.0, 0.4 * tall, shade(colour, 0.45)),
            _ => {}
        }
        x += width + if part(5) > 0.85 { 7.0 } else { 0.0 };
    }
}

/// Boards at the given heights with books between them.
fn bookcase(scene: &mut Scene, left: f32, right: f32, boards: &[f32], seed: u32) {
    let (top, bottom) = (boards[0], boards[boards.len() - 1]);
    scene.rectangle(left - 5.0, top - 4.0, right - left + 10.0, bottom - top + 8.0, WALNUT);
    scene.rectangle(left, top, right - left, bottom - top, shade(WALNUT, 0.5));
    for (n, pair) in boards.windows(2).enumerate() {
        books(scene, left + 1.0, right, pair[1] - 2.0, pair[1] - pair[0] - 4.0, seed + 100 * n as u32);
        scene.rectangle(left, pair[1] - 2.0, right - left, 4.0, OAK);
    }
}

fn kitchen() -> Scene {
    let tiles = Paint::Chequers { colours: [[206.0, 224.0, 226.0], [176.0, 204.0, 210.0]], size: 17.0 };
    let floor = Paint::Chequers { colours: [[190.0, 120.0, 84.0], [120.0, 70.0, 52.0]], size: 26.0 };
    let mut scene = room(tiles, floor, 196.0);
    window(&mut scene, [24.0, 18.0, 84.0, 70.0], 11);
    // worktop with doors, a cooker with four knobs and an oven window
    scene.rectangle(-60.0, 128.0, 270.0, 70.0, CREAM);
    scene.rectangle(-60.0, 120.0, 274.0, 9.0, WALNUT);
    for left in [-30.0, 24.0, 78.0] {
        framed(&mut scene, [left, 138.0, 44.0, 50.0], shade(CREAM, 0.7), shade(CREAM, 0.94));
        scene.disc(left + 38.0, 160.0, 3.0, STEEL);
    }
    scene.rectangle(140.0, 112.0, 74.0, 86.0, STEEL);
    scene.rectangle(148.0, 142.0, 58.0, 42.0, BLACK);
    for knob in 0..4 {
        let x = 152.0 + 16.0 * knob as f32;
        scene.disc(x, 126.0, 5.5, BLACK);
        scene.turned_rectangle((x, 126.0), 30.0 * knob as f32, [1.2, 5.0], WHITE);
    }
    // a pot on the cooker, jars on a shelf, a fridge
    scene.rectangle(154.0, 90.0, 40.0, 22.0, RED);
    scene.rectangle(148.0, 94.0, 52.0, 4.0, BLACK);
    scene.rectangle(170.0, 84.0, 8.0, 6.0, BLACK);
    scene.rectangle(124.0, 56.0, 96.0, 5.0, WALNUT);
    for (n, colour) in [YELLOW, RED, LEAF, BLUE, CREAM].into_iter().enumerate() {
        let left = 128.0 + 18.0 * n as f32;
        let height = 16.0 + 12.0 * hash(5, n as i32, 0);
        scene.rectangle(left, 56.0 - height, 13.0, height, colour);
        scene.rectangle(left - 1.0, 52.0 - height, 15.0, 5.0, BLACK);
        scene.rectangle(left + 3.0, 60.0 - height, 7.0, 7.0, WHITE);
    }
    scene.rectangle(236.0, 30.0, 66.0, 168.0, WHITE);
    scene.rectangle(236.0, 88.0, 66.0, 3.0, STEEL);
    scene.rectangle(242.0, 60.0, 4.0, 22.0, STEEL);
    scene.rectangle(242.0, 98.0, 4.0, 34.0, STEEL);
    let paint = Paint::Writing { colours: [YELLOW, BLACK], size: 6.0, seed: 21 };
    scene.turned_rectangle((274.0, 52.0), -8.0, [13.0, 11.0], paint);
    let paint = Paint::Mosaic { colours: [BLUE, WHITE], size: 6.0, seed: 22 };
    scene.turned_rectangle((272.0, 118.0), 6.0, [16.0, 13.0], paint);
    scene
}

fn office() -> Scene {
    let carpet = Paint::Mosaic { colours: [[70.0, 78.0, 92.0], [86.0, 96.0, 112.0]], size: 5.0, seed: 31 };
    let mut scene = room(wall([196.0, 200.0, 204.0], 30), carpet, 192.0);
    // a whiteboard with a plot, a notice board
    framed(&mut scene, [16.0, 20.0, 124.0, 72.0], STEEL, WHITE);
    scene.rectangle(28.0, 30.0, 2.5, 50.0, BLACK);
    scene.rectangle(28.0, 78.0, 60.0, 2.5, BLACK);
    for n in 0..6 {
        let height = 8.0 + 34.0 * hash(33, n, 0);
        scene.rectangle(33.0 + 9.0 * n as f32, 78.0 - height, 6.0, height, [RED, BLUE, LEAF][n as usize % 3]);
    }
    scene.rectangle(96.0, 28.0, 38.0, 56.0, Paint::Writing { colours: [WHITE, BLUE], size: 8.0, seed: 34 });
    let paint = Paint::Clouds { colours: [[196.0, 152.0, 100.0], [176.0, 130.0, 84.0]], size: 4.0, seed: 35 };
    framed(&mut scene, [176.0, 22.0, 70.0, 58.0], OAK, paint);
    for n in 0..7 {
        let (x, y) = (186.0 + 25.0 * (n % 3) as f32, 34.0 + 17.0 * (n / 3) as f32);
        let note = [YELLOW, WHITE, SKY, [240.0, 160.0, 150.0]][n % 4];
        let paint = Paint::Writing { colours: [note, BLACK], size: 5.0, seed: 37 + n as u32 };
        scene.turned_rectangle((x, y), 24.0 * hash(36, n as i32, 0) - 12.0, [9.5, 7.0], paint);
    }
    // a desk with two screens, a lamp, a chair
    scene.rectangle(20.0, 146.0, 210.0, 8.0, OAK);
    scene.rectangle(28.0, 154.0, 8.0, 56.0, BLACK);
    scene.rectangle(172.0, 154.0, 56.0, 50.0, shade(OAK, 0.8));
    for (n, top) in [158.0, 174.0, 190.0].into_iter().enumerate() {
        scene.rectangle(176.0, top, 48.0, 12.0, shade(OAK, 0.95));
        scene.rectangle(194.0, top + 4.0, 12.0, 3.0, [STEEL, STEEL, BLACK][n]);
    }
    for (left, paint) in [
        (48.0, Paint::Writing { colours: [BLACK, [120.0, 220.0, 140.0]], size: 5.0, seed: 51 }),
        (112.0, Paint::Mosaic { colours: [BLUE, YELLOW], size: 8.0, seed: 52 }),
    ] {
        framed(&mut scene, [left, 102.0, 52.0, 34.0], BLACK, paint);
        scene.rectangle(left + 20.0, 140.0, 12.0, 6.0, BLACK);
    }
    scene.rectangle(196.0, 106.0, 3.0, 40.0, BLACK);
    scene.trapezium((200.0, 104.0), -20.0, [6.0, 15.0, 9.0], RED);
    scene.rectangle(90.0, 160.0, 44.0, 34.0, BLUE);
    scene.rectangle(109.0, 194.0, 6.0, 18.0, BLACK);
    scene.rectangle(92.0, 210.0, 40.0, 5.0, BLACK);
    // a plant
    scene.trapezium((280.0, 190.0), 0.0, [18.0, 12.0, 18.0], RED);
    for n in 0..9 {
        let turn = -72.0 + 18.0 * n as f32;
        let (sin, cos) = turn.to_radians().sin_cos();
        scene.ellipse(
            (280.0 + 30.0 * sin, 172.0 - 34.0 * cos),
            turn,
            [6.0, 32.0],
            shade(LEAF, 0.6 + 0.6 * hash(53, n, 0)),
        );
    }
    scene
}

fn library() -> Scene {
    let boards = Paint::Stripes { colours: [[140.0, 98.0, 60.0], [126.0, 86.0, 52.0]], period: 44.0 };
    let mut scene = room(wall([120.0, 52.0, 48.0], 60), boards, 206.0);
    bookcase(&mut scene, 10.0, 132.0, &[14.0, 60.0, 104.0, 150.0, 200.0], 1000);
    bookcase(&mut scene, 228.0, 340.0, &[14.0, 52.0, 98.0, 140.0, 200.0], 2000);
    // a portrait, a clock, an armchair between the cases
    framed(&mut scene, [152.0, 22.0, 56.0, 66.0], YELLOW, shade(LEAF, 0.5));
    scene.trapezium((180.0, 80.0), 0.0, [10.0, 24.0, 9.0], BLACK);
    scene.disc(180.0, 56.0, 13.0, CREAM);
    scene.ellipse((180.0, 46.0), 0.0, [14.0, 8.0], WALNUT);
    scene.disc(175.0, 55.0, 2.0, BLACK);
    scene.disc(185.0, 55.0, 2.0, BLACK);
    scene.rectangle(175.0, 62.0, 10.0, 2.0, RED);
    scene.rectangle(148.0, 128.0, 64.0, 60.0, LEAF);
    scene.rectangle(156.0, 134.0, 48.0, 34.0, Paint::Dots { colours: [LEAF, YELLOW], size: 12.0, seed: 61 });
    scene.rectangle(140.0, 150.0, 14.0, 48.0, shade(LEAF, 0.7));
    scene.rectangle(206.0, 150.0, 14.0, 48.0, shade(LEAF, 0.7));
    scene.rectangle(152.0, 172.0, 56.0, 18.0, shade(LEAF, 1.2));
    scene.rectangle(144.0, 198.0, 6.0, 10.0, BLACK);
    scene.rectangle(210.0, 198.0, 6.0, 10.0, BLACK);
    scene
}

fn workshop() -> Scene {
    let concrete =
        Paint::Clouds { colours: [[120.0, 118.0, 114.0], [146.0, 144.0, 140.0]], size: 14.0, seed: 71 };
    let bricks = Paint::Mosaic { colours: [[150.0, 84.0, 66.0], [176.0, 106.0, 84.0]], size: 15.0, seed: 70 };
    let mut scene = room(bricks, concrete, 204.0);
    // a pegboard with tools
    let paint = Paint::Dots { colours: [[206.0, 180.0, 138.0], [150.0, 122.0, 84.0]], size: 9.0, seed: 72 };
    framed(&mut scene, [18.0, 18.0, 172.0, 92.0], WALNUT, paint);
    scene.rectangle(30.0, 30.0, 7.0, 58.0, OAK);
    scene.rectangle(22.0, 26.0, 24.0, 12.0, STEEL); // hammer
    scene.turned_rectangle((72.0, 56.0), 24.0, [5.0, 28.0], STEEL);
    scene.ring((60.0, 30.0), 11.0, 5.0, STEEL); // spanner
    scene.triangle((112.0, 62.0), 0.0, [14.0, 34.0], [190.0, 196.0, 204.0]);
    scene.rectangle(100.0, 92.0, 24.0, 12.0, RED); // saw
    for (n, colour) in [RED, BLUE, YELLOW].into_iter().enumerate() {
        let x = 142.0 + 14.0 * n as f32;
        scene.rectangle(x, 28.0, 8.0, 24.0, colour);
        scene.rectangle(x + 2.5, 52.0, 3.0, 30.0, BLACK); // screwdrivers
    }
    // a bench with a vice and drawers
    scene.rectangle(-20.0, 138.0, 230.0, 12.0, OAK);
    scene.rectangle(0.0, 150.0, 14.0, 66.0, WALNUT);
    scene.rectangle(184.0, 150.0, 14.0, 66.0, WALNUT);
    scene.rectangle(36.0, 118.0, 36.0, 20.0, BLUE);
    scene.rectangle(76.0, 116.0, 10.0, 22.0, BLUE);
    scene.rectangle(86.0, 126.0, 26.0, 5.0, STEEL);
    scene.turned_rectangle((112.0, 128.0), 30.0, [2.0, 14.0], BLACK);
    for n in 0..9 {
        let (left, top) = (30.0 + 46.0 * (n % 3) as f32, 154.0 + 18.0 * (n / 3) as f32);
        scene.rectangle(left, top, 42.0, 15.0, [RED, shade(RED, 0.7), STEEL][(n * 7 % 5) % 3]);
        scene.rectangle(left + 14.0, top + 5.0, 14.0, 4.0, WHITE);
    }
    // a warning sign, gas bottles
    scene.triangle((246.0, 54.0), 0.0, [34.0, 29.0], BLACK);
    scene.triangle((246.0, 57.0), 0.0, [25.0, 21.0], YELLOW);
    scene.rectangle(243.0, 50.0, 6.0, 16.0, BLACK);
    scene.disc(246.0, 72.0, 3.5, BLACK);
    for (left, colour) in [(222.0, LEAF), (262.0, [120.0, 40.0, 110.0])] {
        scene.rectangle(left, 122.0, 30.0, 88.0, colour);
        scene.disc(left + 15.0, 122.0, 15.0, shade(colour, 1.2));
        scene.rectangle(left + 10.0, 98.0, 10.0, 14.0, YELLOW);
        let paint = Paint::Writing { colours: [WHITE, BLACK], size: 6.0, seed: 73 };
        scene.rectangle(left + 3.0, 150.0, 24.0, 22.0, paint);
    }
    scene
}

fn hallway() -> Scene {
    let floor = Paint::Stripes { colours: [[168.0, 164.0, 150.0], [150.0, 146.0, 134.0]], period: 60.0 };
    let mut scene = room(wall([222.0, 206.0, 150.0], 80), floor, 200.0);
    scene.rectangle(-2000.0, 110.0, 4000.0, 8.0, shade(LEAF, 0.8));
    // two doors with panels, numbers and handles
    for (n, left) in [28.0, 214.0].into_iter().enumerate() {
        framed(&mut scene, [left, 34.0, 74.0, 164.0], WHITE, BLUE);
        for (dx, dy, height) in [(8.0, 40.0, 48.0), (42.0, 40.0, 48.0), (8.0, 98.0, 56.0), (42.0, 98.0, 56.0)]
        {
            scene.rectangle(left + dx, 34.0 + dy, 24.0, height, shade(BLUE, 0.7));
            scene.rectangle(left + dx + 4.0, 38.0 + dy, 16.0, height - 8.0, shade(BLUE, 1.15));
        }
        let paint = Paint::Mosaic { colours: [BLACK, WHITE], size: 5.0, seed: 81 + n as u32 };
        scene.rectangle(left + 26.0, 44.0, 24.0, 20.0, paint);
        scene.disc(left + 66.0, 126.0, 4.5, YELLOW);
    }
    // a fire extinguisher with its sign, a coat hook rail with coats, a lamp
    scene.rectangle(124.0, 40.0, 24.0, 24.0, RED);
    scene.rectangle(130.0, 46.0, 5.0, 14.0, WHITE);
    scene.triangle((141.0, 52.0), 0.0, [4.0, 8.0], WHITE);
    scene.rectangle(126.0, 136.0, 20.0, 46.0, RED);
    scene.rectangle(131.0, 126.0, 10.0, 10.0, BLACK);
    scene.rectangle(128.0, 148.0, 16.0, 14.0, WHITE);
    scene.turned_rectangle((150.0, 142.0), 20.0, [2.0, 14.0], BLACK);
    scene.rectangle(158.0, 72.0, 50.0, 6.0, WALNUT);
    for (n, colour) in [LEAF, [70.0, 60.0, 90.0], YELLOW].into_iter().enumerate() {
        let x = 166.0 + 16.0 * n as f32;
        scene.trapezium((x, 102.0 + 4.0 * n as f32), 0.0, [4.0, 9.0, 26.0], colour);
        scene.disc(x, 75.0, 3.0, STEEL);
        scene.rectangle(x - 1.0, 84.0, 2.0, 40.0, shade(colour, 0.5));
    }
    scene.rectangle(150.0, -10.0, 4.0, 14.0, BLACK);
    scene.trapezium((152.0, 12.0), 0.0, [8.0, 24.0, 9.0], YELLOW);
    scene
}

fn laboratory() -> Scene {
    let floor = Paint::Dots { colours: [[188.0, 196.0, 194.0], [150.0, 162.0, 164.0]], size: 10.0, seed: 91 };
    let mut scene = room(wall([210.0, 222.0, 220.0], 90), floor, 198.0);
    // a periodic table
    scene.rectangle(14.0, 16.0, 124.0, 74.0, WHITE);
    for n in 0..84 {
        let (column, row) = (n % 14, n / 14);
        let present = row > 2 || !(2..12).contains(&column);
        if present {
            let group = [RED, YELLOW, LEAF, BLUE, SKY, CREAM][(hash(92, column / 3, row / 2) * 6.0) as usize];
            let (left, top) = (18.0 + 8.4 * column as f32, 22.0 + 10.5 * row as f32);
            scene.rectangle(left, top, 7.2, 9.0, group);
            scene.rectangle(left + 2.0, top + 2.0, 3.0, 3.5 + hash(93, n, 0) * 2.0, BLACK);
        }
    }
    // shelves with flasks
    for (n, top) in [64.0, 110.0].into_iter().enumerate() {
        scene.rectangle(164.0, top, 140.0, 5.0, STEEL);
        for k in 0..6 {
            let (x, part) = (176.0 + 23.0 * k as f32, hash(94 + n as u32, k, 0));
            let liquid = [RED, LEAF, YELLOW, BLUE, [150.0, 70.0, 160.0]][(part * 5.0) as usize];
            match (k + n as i32) % 3 {
                0 => {
                    scene.triangle((x, top - 13.0), 0.0, [11.0, 13.0], liquid);
                    scene.rectangle(x - 3.5, top - 32.0, 7.0, 14.0, WHITE);
                }
                1 => {
                    scene.rectangle(x - 6.0, top - 28.0, 12.0, 28.0, WHITE);
                    let height = 16.0 * (0.5 + part);
                    scene.rectangle(x - 5.0, top - height, 10.0, height, liquid);
                }
                _ => {
                    scene.disc(x, top - 10.0, 10.0, liquid);
                    scene.rectangle(x - 3.0, top - 30.0, 6.0, 14.0, SKY);
                    scene.disc(x - 3.0, top - 12.0, 2.5, WHITE);
                }
            }
        }
    }
    // a bench with a microscope, a sink and an instrument with dials
    scene.rectangle(-40.0, 150.0, 380.0, 10.0, BLACK);
    scene.rectangle(-40.0, 160.0, 380.0, 40.0, WHITE);
    for k in 0..6 {
        scene.rectangle(4.0 + 54.0 * k as f32, 164.0, 48.0, 32.0, shade(SKY, 0.85));
        scene.rectangle(20.0 + 54.0 * k as f32, 169.0, 16.0, 4.0, BLACK);
    }
    scene.rectangle(30.0, 142.0, 44.0, 8.0, BLACK);
    scene.turned_rectangle((60.0, 122.0), 20.0, [5.0, 24.0], STEEL);
    scene.turned_rectangle((44.0, 116.0), -30.0, [6.0, 20.0], BLACK);
    scene.rectangle(30.0, 134.0, 26.0, 4.0, STEEL);
    scene.rectangle(92.0, 112.0, 62.0, 38.0, CREAM);
    let paint = Paint::Stripes { colours: [BLACK, [60.0, 200.0, 120.0]], period: 6.0 };
    scene.rectangle(98.0, 118.0, 28.0, 20.0, paint);
    for (k, x) in [134.0, 146.0].into_iter().enumerate() {
        scene.disc(x, 124.0, 5.0, BLACK);
        scene.disc(x, 140.0, 4.0, [RED, LEAF][k]);
    }
    scene
}

fn bedroom() -> Scene {
    let paper =
        Paint::Dots { colours: [[214.0, 190.0, 200.0], [190.0, 150.0, 170.0]], size: 24.0, seed: 101 };
    let floor = Paint::Stripes { colours: [[178.0, 140.0, 96.0], [160.0, 122.0, 82.0]], period: 34.0 };
    let mut scene = room(paper, floor, 200.0);
    window(&mut scene, [206.0, 20.0, 88.0, 84.0], 102);
    for left in [184.0, 292.0] {
        let paint = Paint::Stripes { colours: [[150.0, 50.0, 80.0], [176.0, 74.0, 104.0]], period: 8.0 };
        scene.rectangle(left, 10.0, 24.0, 112.0, paint);
    }
    scene.rectangle(176.0, 8.0, 148.0, 5.0, WALNUT);
    // a bed with a patchwork quilt, two pillows, a headboard
    scene.rectangle(10.0, 84.0, 14.0, 122.0, WALNUT);
    let paint =
        Paint::Mosaic { colours: [[60.0, 70.0, 130.0], [240.0, 200.0, 170.0]], size: 18.0, seed: 103 };
    scene.rectangle(22.0, 140.0, 164.0, 54.0, paint);
    scene.rectangle(22.0, 188.0, 164.0, 10.0, WALNUT);
    scene.rectangle(180.0, 150.0, 8.0, 58.0, WALNUT);
    scene.turned_rectangle((50.0, 134.0), -8.0, [24.0, 10.0], WHITE);
    scene.turned_rectangle(
        (58.0, 128.0),
        14.0,
        [16.0, 8.0],
        Paint::Chequers { colours: [RED, WHITE], size: 6.0 },
    );
    // pictures, a bedside table with a lamp and an alarm clock
    let paint = Paint::Mosaic { colours: [YELLOW, RED], size: 11.0, seed: 104 };
    framed(&mut scene, [54.0, 26.0, 44.0, 56.0], BLACK, paint);
    let paint = Paint::Clouds { colours: [BLUE, CREAM], size: 9.0, seed: 105 };
    framed(&mut scene, [120.0, 40.0, 40.0, 30.0], WHITE, paint);
    scene.rectangle(216.0, 154.0, 62.0, 52.0, OAK);
    scene.rectangle(222.0, 162.0, 50.0, 16.0, shade(OAK, 0.75));
    scene.rectangle(222.0, 182.0, 50.0, 16.0, shade(OAK, 0.75));
    scene.disc(247.0, 170.0, 3.0, BLACK);
    scene.disc(247.0, 190.0, 3.0, BLACK);
    scene.rectangle(228.0, 134.0, 4.0, 20.0, BLACK);
    scene.trapezium((230.0, 124.0), 0.0, [9.0, 17.0, 12.0], YELLOW);
    scene.disc(260.0, 143.0, 11.0, BLACK);
    scene.disc(260.0, 143.0, 8.5, WHITE);
    scene.rectangle(259.0, 136.0, 2.0, 8.0, BLACK);
    scene.rectangle(259.0, 142.0, 7.0, 2.0, BLACK);
    scene.disc(252.0, 133.0, 4.0, STEEL);
    scene.disc(268.0, 133.0, 4.0, STEEL);
    scene
}

fn storeroom() -> Scene {
    let floor = Paint::Clouds { colours: [[96.0, 92.0, 88.0], [112.0, 108.0, 102.0]], size: 8.0, seed: 111 };
    let mut scene = room(wall([160.0, 166.0, 156.0], 110), floor, 208.0);
    // racks: uprights with holes, boards, boxes of hashed sizes with labels
    for (n, bottom) in [72.0, 136.0, 200.0].into_iter().enumerate() {
        let mut left = 8.0;
        for k in 0.. {
            let part = |salt: u32| hash(112 + salt, k, n as i32);
            let (width, height) = (28.0 + 30.0 * part(0), 24.0 + 26.0 * part(1));
            if left + width > 312.0 {
                break;
            }
            let carton = shade([200.0, 158.0, 108.0], 0.7 + 0.35 * part(2));
            scene.rectangle(left, bottom - height, width, height, carton);
            scene.rectangle(left + width * 0.42, bottom - height, width * 0.16, height, shade(carton, 1.2));
            match (part(3) * 4.0) as u32 {
                0 => {
                    let address = Paint::Writing { colours: [WHITE, BLACK], size: 4.5, seed: 120 + k as u32 };
                    scene.rectangle(left + 4.0, bottom - height + 6.0, 15.0, 11.0, address);
                }
                1 => {
                    let middle = (left + width * 0.7, bottom - height * 0.5);
                    scene.triangle(middle, 0.0, [6.0, 7.0], RED);
                }
                2 => {
                    let bars = Paint::Stripes { colours: [WHITE, BLACK], period: 3.5 };
                    scene.rectangle(left + 3.0, bottom - 14.0, 12.0, 10.0, bars);
                }
                _ => scene.disc(left + width * 0.25, bottom - height * 0.55, 5.5, BLUE),
            }
            left += width + 3.0 + 9.0 * part(4);
        }
        scene.rectangle(-10.0, bottom, 340.0, 6.0, BLUE);
    }
    for left in [-2.0, 154.0, 310.0] {
        scene.rectangle(left, 8.0, 9.0, 206.0, shade(BLUE, 0.8));
        for hole in 0..13 {
            scene.rectangle(left + 3.0, 14.0 + 15.0 * hole as f32, 3.0, 6.0, BLACK);
        }
    }
    // a ladder before them
    for (x, turn) in [(226.0, 7.0), (258.0, 7.0)] {
        scene.turned_rectangle((x, 118.0), turn, [3.0, 104.0], YELLOW);
    }
    for rung in 0..7 {
        let down = 28.0 + 29.0 * rung as f32;
        scene.turned_rectangle((242.0 + (118.0 - down) * 0.12, down), 0.0, [17.0, 2.0], shade(YELLOW, 0.7));
    }
    scene
}
