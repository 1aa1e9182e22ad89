//! A workcell: a database is trained on things seen from right above; these lie on a table, with one that it was not
//! trained on. The overview camera's picture is inspected, and the answer about every part is compared with the truth.
//! Then the camera at the gripper is centred on one of them.

use std::io::Write;
use std::path::Path;

use serde_json::{Value, json};

use super::client::InspectedPart;
use super::data_sets::Exemplar;
use super::drawing::{View, hash};
use super::files::replace_folder;
use super::table::{PlacedThing, Table};
use super::turntable::{WITHOUT_POSE, known_things, unknown_things};
use super::{DemoError, train, verdict};
use crate::client::Server;
use crate::evaluate::{PoseErrors, Rate};
use landmarkd_core::angle::angular_distance_deg;
use landmarkd_core::imaging::encode::png_rgb8;
use landmarkd_core::statistics::nearest_rank;

/// The database.
pub const DATABASE: &str = "demo-workcell";
/// The workcell.
const WORKCELL: &str = "demo";
/// From one training view to the next.
const STEP_DEG: usize = 10;
/// Width and height of a training picture.
const VIEW_PX: usize = 160;
/// The overview camera's pictures, and its scale on the table.
const OVERVIEW_PX: (usize, usize) = (640, 480);
const OVERVIEW_MM_PER_PX: f32 = 0.75;
/// Training pictures show things somewhere on the table, in the light that is there: at most so far from its middle,
/// and from the picture's.
const TRAINED_MM: [f32; 2] = [190.0, 140.0];
const TRAINED_OFF_MM: f32 = 3.0;
/// By which part the light is less at the right edge of the table.
const SHADE: f32 = 0.2;
/// The table has cells in columns and rows; a thing lies in each cell but the last, at most so far off its middle.
const COLUMNS: usize = 3;
const CELL_MM: [f32; 2] = [160.0, 180.0];
const OFF_MM: [f32; 2] = [25.0, 30.0];
/// Where the robot has the table's middle, and the direction of the table's x axis in its plane, from X towards Y.
const ROBOT_MIDDLE_MM: [f64; 2] = [420.0, -150.0];
const ROBOT_TURN_DEG: f64 = 12.0;
/// Pixels of the overview whose points the robot has touched, and the resolution of its coordinates.
const TOUCHED_PX: [[f64; 2]; 4] = [[40.0, 40.0], [600.0, 40.0], [600.0, 440.0], [40.0, 440.0]];
const TOUCHED_RESOLUTION_MM: f64 = 0.1;
/// A region further from a part than this is not the part's.
const SAME_PX: f64 = 25.0;
/// The part to centre on.
const CENTRED: &str = "truck";
/// The camera at the gripper: its pictures, its true scale, its scale by the workcell, its angle on the table.
const LOCAL_PX: (usize, usize) = (480, 360);
const LOCAL_MM_PER_PX: f64 = 0.45;
const MEASURED_MM_PER_PX: f64 = 0.43;
const LOCAL_TURN_DEG: f64 = 20.0;
/// How far from the part the gripper arrives, X and Y.
const ARRIVAL_OFFSET_MM: [f64; 2] = [-10.8, 8.1];
/// B§3: how often the gripper is moved.
const MOVES: usize = 2;

/// How often parts were found and named, and how far their poses and places were off.
#[derive(Clone, Debug, PartialEq)]
pub struct InspectionSummary {
    /// Parts with a region of their own.
    pub found: Rate,
    /// Known parts that were named right.
    pub named_right: Rate,
    /// Parts not trained on that were answered "unknown".
    pub unknown_refused: Rate,
    /// Of known parts named right that have a pose, whether it calls itself reliable or not; `None` without any.
    pub turn_errors: Option<PoseErrors>,
    /// Distances from the true places to the answered ones, of all parts found.
    pub place_errors: Option<PlaceErrors>,
    /// How far the part is from the middle of the gripper's picture: before, and after each move.
    pub centring_px: Vec<f64>,
    /// Whether the service calls the part centred at the end.
    pub centred: bool,
}

/// How far answered places were from the true ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceErrors {
    /// Parts with an answered place.
    pub trials: usize,
    /// By nearest rank.
    pub median_mm: f64,
    /// The largest error.
    pub worst_mm: f64,
}

impl PlaceErrors {
    /// `None` of nothing.
    fn of(mut errors_mm: Vec<f64>) -> Option<PlaceErrors> {
        errors_mm.sort_by(f64::total_cmp);
        let worst_mm = *errors_mm.last()?;
        Some(PlaceErrors { trials: errors_mm.len(), median_mm: nearest_rank(&errors_mm, 0.50)?, worst_mm })
    }
}

/// A part on the table.
struct Part {
    label: &'static str,
    /// Whether the database was trained on it.
    known: bool,
    placed: PlacedThing,
}

impl Part {
    fn has_pose(&self) -> bool {
        self.known && self.label != WITHOUT_POSE
    }

    /// Where the robot finds it.
    fn robot_mm(&self) -> [f64; 2] {
        robot_mm(self.placed.middle_mm())
    }
}

/// The overview camera, above a point of the table.
fn overview(x: f32, y: f32) -> View {
    View { scale: 1.0 / OVERVIEW_MM_PER_PX, ..View::of(x, y) }
}

fn rotated([x, y]: [f64; 2], turn_deg: f64) -> [f64; 2] {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// Where the robot has a point of the table: its Y grows where the table's y falls.
fn robot_mm([x, y]: [f64; 2]) -> [f64; 2] {
    let [x, y] = rotated([x, -y], ROBOT_TURN_DEG);
    [ROBOT_MIDDLE_MM[0] + x, ROBOT_MIDDLE_MM[1] + y]
}

/// The point of the table where the robot is.
fn table_mm([x, y]: [f64; 2]) -> [f64; 2] {
    let [x, y] = rotated([x - ROBOT_MIDDLE_MM[0], y - ROBOT_MIDDLE_MM[1]], -ROBOT_TURN_DEG);
    [x, -y]
}

/// The point of the table that a pixel of the overview shows.
fn shown_mm([x, y]: [f64; 2]) -> [f64; 2] {
    let from_middle =
        |at: f64, length: usize| (at - (length as f64 - 1.0) / 2.0) * f64::from(OVERVIEW_MM_PER_PX);
    [from_middle(x, OVERVIEW_PX.0), from_middle(y, OVERVIEW_PX.1)]
}

/// The pixel of the overview that shows a point of the table.
fn overview_px([x, y]: [f64; 2]) -> [f64; 2] {
    let pixel = |at: f64, length: usize| at / f64::from(OVERVIEW_MM_PER_PX) + (length as f64 - 1.0) / 2.0;
    [pixel(x, OVERVIEW_PX.0), pixel(y, OVERVIEW_PX.1)]
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Every known thing from right above, each alone somewhere on the table, turned step by step.
fn views() -> Vec<Exemplar> {
    let mut views = Vec::new();
    for (label, thing) in known_things() {
        for turn_deg in (0..360).step_by(STEP_DEG) {
            let choice = |salt: u32| 2.0 * hash(1400 + salt, views.len() as i32, 0) - 1.0;
            let (x_mm, y_mm) = (TRAINED_MM[0] * choice(0), TRAINED_MM[1] * choice(1));
            let placed = PlacedThing { thing: thing.clone(), x_mm, y_mm, turn_deg: turn_deg as f32 };
            let table = Table { things: vec![placed], shade: SHADE };
            let view = overview(x_mm + TRAINED_OFF_MM * choice(2), y_mm + TRAINED_OFF_MM * choice(3));
            let bytes = table.photographed(view, (VIEW_PX, VIEW_PX), 5000 + 2 * views.len() as u32);
            let png = png_rgb8(VIEW_PX, VIEW_PX, &bytes);
            views.push(Exemplar { label: label.into(), pose_deg: Some(turn_deg as f64), png });
        }
    }
    views
}

/// The parts on the table: every known thing and one unknown, each at a seeded place and angle.
fn parts() -> Vec<Part> {
    let known = known_things().into_iter().map(|(name, thing)| (name, thing, true));
    let unknown = unknown_things().into_iter().take(1).map(|(name, thing)| (name, thing, false));
    let place = |(n, (label, thing, known))| {
        let choice = |salt: u32| hash(1300 + salt, n as i32, 0);
        let off = |axis: usize| OFF_MM[axis] * (2.0 * choice(axis as u32) - 1.0);
        let (column, row) = ((n % COLUMNS) as f32, (n / COLUMNS) as f32);
        let (x_mm, y_mm) = ((column - 1.0) * CELL_MM[0] + off(0), (row - 0.5) * CELL_MM[1] + off(1));
        let turn_deg = (3600.0 * choice(2)).round() / 10.0;
        Part { label, known, placed: PlacedThing { thing, x_mm, y_mm, turn_deg } }
    };
    known.chain(unknown).enumerate().map(place).collect()
}

fn table(parts: &[Part]) -> Table {
    Table { things: parts.iter().map(|part| part.placed.clone()).collect(), shade: SHADE }
}

fn photographed(table: &Table) -> Vec<u8> {
    png_rgb8(OVERVIEW_PX.0, OVERVIEW_PX.1, &table.photographed(overview(0.0, 0.0), OVERVIEW_PX, 6000))
}

/// The picture of the camera at the gripper, which is at a point of the robot's plane.
fn seen_from_gripper(table: &Table, gripper_mm: [f64; 2], seed: u32) -> Vec<u8> {
    let [x, y] = table_mm(gripper_mm).map(|at| at as f32);
    let view = View { x, y, turn_deg: LOCAL_TURN_DEG as f32, scale: (1.0 / LOCAL_MM_PER_PX) as f32 };
    png_rgb8(LOCAL_PX.0, LOCAL_PX.1, &table.photographed(view, LOCAL_PX, seed))
}

/// The workcell as the contract has it.
fn workcell() -> Value {
    let touched = |image_px: [f64; 2]| {
        let exactly = |at: f64| (at / TOUCHED_RESOLUTION_MM).round() * TOUCHED_RESOLUTION_MM;
        json!({"image_px": image_px, "robot_mm": robot_mm(shown_mm(image_px)).map(exactly)})
    };
    json!({
        "database": DATABASE,
        "correspondences": TOUCHED_PX.map(touched),
        "local": {"mm_per_px": MEASURED_MM_PER_PX, "rotation_deg": ROBOT_TURN_DEG + LOCAL_TURN_DEG},
    })
}

/// Trains, inspects the table, prints a row a part and the summary, centres; the pictures go below `pictures_dir`.
///
/// # Errors
/// [`DemoError`] when the service doesn't answer or refuses, or a file can't be written.
pub async fn show(
    server: &Server,
    pictures_dir: &Path,
    out: &mut dyn Write,
) -> Result<InspectionSummary, DemoError> {
    // A database that a workcell of a run before uses can't be deleted.
    server.delete(&["workcells", WORKCELL]).await?;
    let document = json!({"kind": "objects", "options": {"segment": true}});
    let version = train(server, DATABASE, &document, &views(), out).await?;
    server.create(&["workcells", WORKCELL], &workcell()).await?;

    let parts = parts();
    let table = table(&parts);
    let picture = photographed(&table);
    let inspection = server.inspect(WORKCELL, version, &picture).await?;
    let mut pictures = vec![
        ("annotated.png".to_owned(), server.inspection_annotated(WORKCELL, &picture).await?),
        ("regions.png".to_owned(), server.regions(&picture, "image/png; preview=regions").await?),
        ("labels.png".to_owned(), server.regions(&picture, "image/png").await?),
        ("table.png".to_owned(), picture),
    ];
    let answers: Vec<PartAnswer> =
        parts.iter().map(|part| PartAnswer::of(part, &inspection.objects)).collect();
    print_rows(&answers, out)?;
    let centred = answers.iter().find(|answer| answer.part.label == CENTRED);
    let centring = match centred.and_then(|answer| Some((answer.part, answer.found?.robot_mm?))) {
        Some((part, answered_mm)) => centre(server, &table, part, answered_mm, &mut pictures).await?,
        None => Centring::default(),
    };
    replace_folder(&pictures_dir.join(DATABASE), pictures.iter().map(|(name, png)| (name.clone(), png)))?;
    let summary = InspectionSummary::of(&answers, centring);
    summary.print(inspection.timings_ms.total, out)?;
    Ok(summary)
}

/// How the gripper came to the middle of a part.
#[derive(Default)]
struct Centring {
    /// How far off it was: before, and after each move.
    offsets_px: Vec<f64>,
    /// The service's last verdict.
    centred: bool,
}

/// Moves the gripper as the service answers, from beside the place where it found the part; adds the pictures taken.
async fn centre(
    server: &Server,
    table: &Table,
    part: &Part,
    [x, y]: [f64; 2],
    pictures: &mut Vec<(String, Vec<u8>)>,
) -> Result<Centring, DemoError> {
    let mut centring = Centring::default();
    let mut gripper_mm = [x + ARRIVAL_OFFSET_MM[0], y + ARRIVAL_OFFSET_MM[1]];
    for moves in 0..=MOVES {
        centring.offsets_px.push(apart(gripper_mm, part.robot_mm()) / LOCAL_MM_PER_PX);
        let picture = seen_from_gripper(table, gripper_mm, 7000 + 2 * moves as u32);
        let answer = server.centre(WORKCELL, &picture).await?;
        pictures.push((format!("gripper-{moves}.png"), picture));
        centring.centred = answer.centred;
        gripper_mm = [0, 1].map(|axis| gripper_mm[axis] + answer.move_mm[axis]);
    }
    Ok(centring)
}

fn print_rows(answers: &[PartAnswer], out: &mut dyn Write) -> Result<(), DemoError> {
    let [part, answered, turned, truly, at, off] =
        ["part", "answered", "turned by", "truly", "at, robot mm", "off"];
    writeln!(out, "  {part:<8}{answered:<10}{turned:>10}{truly:>8}{at:>20}{truly:>18}{off:>8}")?;
    answers.iter().try_for_each(|answer| writeln!(out, "  {}", answer.line()))?;
    Ok(())
}

/// Prints the call with curl that inspects the table.
pub fn print_calls(base_url: &str, pictures_dir: &Path, out: &mut dyn Write) -> Result<(), DemoError> {
    let file = pictures_dir.join(DATABASE).join("table.png");
    Ok(writeln!(
        out,
        "inspect the table, and see what is said of every part:\n  curl -F 'overview=@{}' \\\n    \
         -H 'Accept: image/png' -o inspected.png '{base_url}/v1/workcells/{WORKCELL}/inspections'",
        file.display()
    )?)
}

/// A part and the answer about it.
struct PartAnswer<'a> {
    part: &'a Part,
    /// `None`: no region lies where the part is.
    found: Option<&'a InspectedPart>,
}

impl<'a> PartAnswer<'a> {
    fn of(part: &'a Part, objects: &'a [InspectedPart]) -> PartAnswer<'a> {
        let middle_px = overview_px(part.placed.middle_mm());
        let distance = |object: &InspectedPart| apart(object.region.centroid_px, middle_px);
        let nearest = objects.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        PartAnswer { part, found: nearest.filter(|nearest| distance(nearest) < SAME_PX) }
    }

    fn label(&self) -> Option<&str> {
        self.found.and_then(|found| found.recognition.label())
    }

    /// Found, and named as what it is; a part not trained on: answered "unknown".
    fn is_right(&self) -> bool {
        self.found.is_some() && self.label() == self.part.known.then_some(self.part.label)
    }

    /// Of a part that is named right and has a pose.
    fn turn_error_deg(&self) -> Option<f64> {
        let pose = self.found.filter(|_| self.part.has_pose() && self.is_right())?.recognition.pose?;
        Some(angular_distance_deg(pose.turn_deg, f64::from(self.part.placed.turn_deg)))
    }

    fn place_error_mm(&self) -> Option<f64> {
        Some(apart(self.found?.robot_mm?, self.part.robot_mm()))
    }

    fn line(&self) -> String {
        let part = self.part;
        let point = |[x, y]: [f64; 2]| format!("({x:.1}, {y:.1})");
        let pose = self.found.and_then(|found| found.recognition.pose);
        let doubt = |reliable: bool| if reliable { "" } else { "?" };
        let turn = pose.map(|pose| format!("{:.1}°{}", pose.turn_deg, doubt(pose.reliable)));
        let true_turn = part.has_pose().then(|| format!("{:.1}°", part.placed.turn_deg));
        let place = self.found.and_then(|found| found.robot_mm).map(point);
        let off = self.place_error_mm().map(|off_mm| format!("{off_mm:.2}"));
        let [turn, true_turn, place, off] = [turn, true_turn, place, off].map(Option::unwrap_or_default);
        let (label, named) = (part.label, self.label().unwrap_or("nothing"));
        let (true_place, verdict) = (point(part.robot_mm()), verdict(self.is_right()));
        format!("{label:<8}{named:<10}{turn:>10}{true_turn:>8}{place:>20}{true_place:>18}{off:>8}  {verdict}")
    }
}

impl InspectionSummary {
    fn of(answers: &[PartAnswer], centring: Centring) -> InspectionSummary {
        let (known, unknown): (Vec<&PartAnswer>, Vec<&PartAnswer>) =
            answers.iter().partition(|answer| answer.part.known);
        InspectionSummary {
            found: Rate::among(answers.iter().map(|answer| answer.found.is_some())),
            named_right: Rate::among(known.iter().map(|answer| answer.is_right())),
            unknown_refused: Rate::among(unknown.iter().map(|answer| answer.is_right())),
            turn_errors: PoseErrors::of(answers.iter().filter_map(PartAnswer::turn_error_deg).collect()),
            place_errors: PlaceErrors::of(answers.iter().filter_map(PartAnswer::place_error_mm).collect()),
            centring_px: centring.offsets_px,
            centred: centring.centred,
        }
    }

    fn print(&self, inspect_ms: f64, out: &mut dyn Write) -> Result<(), DemoError> {
        let [found, right, refused] = [self.found, self.named_right, self.unknown_refused].map(Rate::counts);
        writeln!(out, "  found: {found} in {inspect_ms:.0} ms; named right: {right}")?;
        writeln!(out, "  never learned: {refused} refused")?;
        if let Some(PoseErrors { trials, median_deg, worst_deg, .. }) = self.turn_errors {
            writeln!(
                out,
                "  turn error of {trials}, those not called reliable (?) too: median {median_deg:.1}°, worst {worst_deg:.1}°"
            )?;
        }
        if let Some(PlaceErrors { trials, median_mm, worst_mm }) = self.place_errors {
            writeln!(out, "  place error of {trials}: median {median_mm:.2} mm, worst {worst_mm:.2} mm")?;
        }
        let offsets: Vec<String> = self.centring_px.iter().map(|off_px| format!("{off_px:.1}")).collect();
        let verdict = if self.centred { "centred" } else { "not centred" };
        writeln!(
            out,
            "  the gripper's camera over the {CENTRED}: {} px off before and after each move, {verdict}",
            offsets.join(", ")
        )?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::client::{AnsweredPose, Decision, Recognition, Region};
    use landmarkd_core::imaging::{DecodeLimits, Frame, decode};
    use landmarkd_core::recognition::objects::{
        Normaliser, ObjectOptions, View, ViewName, common_step_deg, train,
    };
    use landmarkd_core::vision::segmentation::SegmentationOptions;
    use landmarkd_core::workcell::{Correspondence, Mapping, Workcell};

    fn frame(png: &[u8]) -> Frame {
        decode(png, &DecodeLimits::default()).unwrap()
    }

    fn recognition(label: Option<String>, pose: Option<AnsweredPose>) -> Recognition {
        let decision = label.map(|label| Decision { label, confidence: None });
        Recognition { decision, pose, ..Recognition::default() }
    }

    #[test]
    fn parts_lie_apart_and_wholly_in_the_overview() {
        let parts = parts();
        assert_eq!(parts.iter().map(|part| part.known).collect::<Vec<_>>(), [true, true, true, true, false]);
        for (n, part) in parts.iter().enumerate() {
            let at = |part: &Part| [part.placed.x_mm, part.placed.y_mm].map(f64::from);
            let [x, y] = overview_px(at(part));
            assert!((70.0..570.0).contains(&x) && (70.0..410.0).contains(&y), "{}: {x}, {y}", part.label);
            for other in &parts[n + 1..] {
                assert!(apart(at(part), at(other)) > 100.0, "{} and {}", part.label, other.label);
            }
            let [x, y] = table_mm(part.robot_mm());
            assert!(apart([x, y], part.placed.middle_mm()) < 1e-9, "{}", part.label);
            let [x, y] = shown_mm(overview_px([x, y]));
            assert!(apart([x, y], part.placed.middle_mm()) < 1e-9, "{}", part.label);
        }
    }

    #[test]
    fn the_robots_x_axis_is_turned_and_its_y_grows_to_the_pictures_top() {
        let [x, y] = robot_mm([100.0, 0.0]);
        let turn = ROBOT_TURN_DEG.to_radians();
        assert!(apart([x, y], [420.0 + 100.0 * turn.cos(), -150.0 + 100.0 * turn.sin()]) < 1e-9, "{x}, {y}");
        assert!(robot_mm([0.0, -100.0])[1] > -60.0);
    }

    #[test]
    fn what_the_gripper_sees_off_its_middle_is_off_by_that_much_on_the_table() {
        let part = parts().into_iter().find(|part| part.label == CENTRED).unwrap();
        let table = Table { things: vec![part.placed.clone()], shade: 0.0 };
        let truth = part.robot_mm();
        let gripper_mm = [truth[0] + ARRIVAL_OFFSET_MM[0], truth[1] + ARRIVAL_OFFSET_MM[1]];
        let seen = frame(&seen_from_gripper(&table, gripper_mm, 1)).luminance;
        let pixels = (0..LOCAL_PX.1).flat_map(|y| (0..LOCAL_PX.0).map(move |x| (x, y)));
        let lit: Vec<(usize, usize)> = pixels.filter(|&(x, y)| seen.at(x, y) > 21.0).collect();
        let mean =
            |at: fn(&(usize, usize)) -> usize| lit.iter().map(at).sum::<usize>() as f64 / lit.len() as f64;
        let off_px = [
            mean(|p| p.0) - (LOCAL_PX.0 as f64 - 1.0) / 2.0,
            mean(|p| p.1) - (LOCAL_PX.1 as f64 - 1.0) / 2.0,
        ];
        assert!((29.0..31.0).contains(&off_px[0].hypot(off_px[1])), "{off_px:?}");
        let [x, y] = rotated([off_px[0], -off_px[1]], ROBOT_TURN_DEG + LOCAL_TURN_DEG);
        let moved = [gripper_mm[0] + LOCAL_MM_PER_PX * x, gripper_mm[1] + LOCAL_MM_PER_PX * y];
        assert!(apart(moved, truth) < 0.2, "{moved:?} {truth:?}");
    }

    /// The core's answers about the overview, with its default options.
    fn core_answers(parts: &[Part]) -> Vec<InspectedPart> {
        let options = ObjectOptions { segment: true, ..ObjectOptions::default() };
        let views = views();
        let posed = views.iter().map(|view| (view.label.as_str(), view.pose_deg));
        let normaliser =
            Normaliser::new(&options, (VIEW_PX as u32, VIEW_PX as u32)).with_step_deg(common_step_deg(posed));
        let views = views.into_iter().enumerate().map(|(n, view)| {
            let name = ViewName { id: n.to_string(), label: view.label, pose_deg: view.pose_deg };
            View::new(&normaliser, name, &frame(&view.png), true).unwrap()
        });
        let (model, _) = train(views.collect(), &normaliser, &options).unwrap();
        let touched =
            TOUCHED_PX.map(|image_px| Correspondence { image_px, robot_mm: robot_mm(shown_mm(image_px)) });
        let workcell = Workcell {
            mapping: Mapping::fit(&touched, None, true).unwrap(),
            flip_y: true,
            local: None,
            tolerance_px: 1.0,
            segmentation: SegmentationOptions::default(),
        };
        let overview = frame(&photographed(&table(parts)));
        let inspection = landmarkd_core::workcell::inspect(&overview, &workcell, &model, |_| ());
        let found = inspection.parts.into_iter().map(|part| {
            let decision = part.recognition.decision;
            let pose = decision.as_ref().and_then(|decision| decision.pose).map(|pose| AnsweredPose {
                turn_deg: pose.turn_deg,
                sigma_deg: pose.sigma_deg,
                reliable: pose.reliable,
            });
            InspectedPart {
                region: Region { centroid_px: part.region.centroid_px },
                robot_mm: part.robot_mm,
                recognition: recognition(decision.map(|decision| decision.label), pose),
            }
        });
        found.collect()
    }

    #[test]
    fn drawn_parts_are_named_and_placed_and_the_unknown_one_is_refused() {
        let parts = parts();
        let found = core_answers(&parts);
        let answers: Vec<PartAnswer> = parts.iter().map(|part| PartAnswer::of(part, &found)).collect();
        for answer in &answers {
            println!("{}", answer.line());
        }
        let summary = InspectionSummary::of(&answers, Centring::default());
        assert_eq!((found.len(), summary.found), (5, Rate::of(5, 5)));
        assert_eq!((summary.named_right, summary.unknown_refused), (Rate::of(4, 4), Rate::of(1, 1)));
        let (turns, places) = (summary.turn_errors.unwrap(), summary.place_errors.unwrap());
        assert!(turns.worst_deg <= 5.0, "{turns}");
        assert!(places.worst_mm <= 1.0, "{places:?}");
    }

    #[test]
    fn a_summary_counts_each_part_where_it_belongs() {
        let parts = parts();
        let answered = |part: &Part, label: &str, off_mm: f64| {
            let [x, y] = part.robot_mm();
            let turn_deg = f64::from(part.placed.turn_deg) + 2.0;
            InspectedPart {
                region: Region { centroid_px: overview_px(part.placed.middle_mm()) },
                robot_mm: Some([x + off_mm, y]),
                recognition: recognition(
                    Some(label.to_owned()),
                    Some(AnsweredPose { turn_deg, sigma_deg: 1.0, reliable: false }),
                ),
            }
        };
        // the house named right, the mug as a house, the truck not found, the vase right, the unknown one a mug
        let found = [
            answered(&parts[4], "mug", 3.0),
            answered(&parts[3], WITHOUT_POSE, 1.0),
            answered(&parts[1], "house", 2.0),
            answered(&parts[0], "house", 4.0),
        ];
        let answers: Vec<PartAnswer> = parts.iter().map(|part| PartAnswer::of(part, &found)).collect();
        let summary =
            InspectionSummary::of(&answers, Centring { offsets_px: vec![30.0, 1.0], centred: true });
        assert_eq!(summary.found, Rate::of(4, 5));
        assert_eq!(summary.named_right, Rate::of(2, 4));
        assert_eq!(summary.unknown_refused, Rate::of(0, 1));
        let turns = summary.turn_errors.unwrap();
        assert_eq!(turns.trials, 1, "the house alone is named right and has a pose");
        assert!((turns.worst_deg - 2.0).abs() < 1e-6, "{turns}");
        let places = summary.place_errors.unwrap();
        assert_eq!(places.trials, 4);
        assert!((places.median_mm - 2.0).abs() < 1e-9 && (places.worst_mm - 4.0).abs() < 1e-9, "{places:?}");
    }
}
