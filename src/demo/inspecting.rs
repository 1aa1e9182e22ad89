//! The last act: a workcell. Things learned from right above lie on a table, with one that was never learned; the
//! overview camera's picture is inspected, and what the service says of every part is held against the truth. Then the
//! camera at the gripper is centred on one of them.

use std::io::Write;
use std::path::Path;

use serde_json::{Value, json};

use super::client::{InspectedPart, Server};
use super::drawing::{View, hash};
use super::lessons::Exemplar;
use super::table::{Standing, Table};
use super::turntable::{WITHOUT_POSE, known_things, strange_things};
use super::{DemoError, keep_in};
use crate::evaluate::{PoseErrors, Rate, degrees_apart};
use landmarkd_core::imaging::encode::png_rgb8;

/// The database of the last act.
pub const DATABASE: &str = "demo-workcell";
/// The workcell.
const WORKCELL: &str = "demo";
/// From one learned view to the next.
const STEP_DEG: usize = 10;
/// Width and height of a learned picture.
const VIEW_PX: usize = 160;
/// The overview camera's pictures, and its scale on the table.
const OVERVIEW_PX: (usize, usize) = (640, 480);
const OVERVIEW_MM_PER_PX: f32 = 0.75;
/// Things are learned somewhere on the table, in the light that is there: so far from its middle, and so far from the
/// picture's.
const LEARNED_MM: [f32; 2] = [190.0, 140.0];
const LEARNED_OFF_MM: f32 = 3.0;
/// By what part the light is less at the right edge of the table.
const SHADE: f32 = 0.2;
/// The table is parted into columns and rows; a thing lies in each part but the last, off its middle by so much.
const COLUMNS: usize = 3;
const PART_MM: [f32; 2] = [160.0, 180.0];
const OFF_MM: [f32; 2] = [25.0, 30.0];
/// Where the robot has the table's middle, and the direction of the table's x axis in its plane, from X towards Y.
const ROBOT_MIDDLE_MM: [f64; 2] = [420.0, -150.0];
const ROBOT_TURN_DEG: f64 = 12.0;
/// Pixels of the overview whose places the robot has touched, and how exactly it knows where.
const TOUCHED_PX: [[f64; 2]; 4] = [[40.0, 40.0], [600.0, 40.0], [600.0, 440.0], [40.0, 440.0]];
const TOUCHED_TO_MM: f64 = 0.1;
/// A region further from a part than this is another one.
const SAME_PX: f64 = 25.0;
/// What is centred.
const CENTRED: &str = "truck";
/// The camera at the gripper: its pictures, its scale, the one that it was measured to have, its turn on the table.
const LOCAL_PX: (usize, usize) = (480, 360);
const LOCAL_MM_PER_PX: f64 = 0.45;
const MEASURED_MM_PER_PX: f64 = 0.43;
const LOCAL_TURN_DEG: f64 = 20.0;
/// How far from the part the gripper arrives, X and Y.
const STRAY_MM: [f64; 2] = [-10.8, 8.1];
/// B§3: the gripper is moved so often.
const MOVES: usize = 2;

/// How the last act went.
#[derive(Clone, Debug, PartialEq)]
pub struct InspectingSummary {
    /// Parts with a region of their own.
    pub found: Rate,
    /// Known parts that were named right.
    pub named_right: Rate,
    /// Parts never learned that were refused.
    pub strange_refused: Rate,
    /// Of known parts named right that have a pose, whether it calls itself reliable or not; `None` without any.
    pub turn_errors: Option<PoseErrors>,
    /// From where a part is to where the service says, of all that were found.
    pub place_errors: Option<PlaceErrors>,
    /// How far the part is from the middle of the gripper's picture: before, and after each move.
    pub centring_px: Vec<f64>,
    /// Whether the service calls the part centred at the end.
    pub centred: bool,
}

/// How far told places were from the true ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceErrors {
    pub trials: usize,
    pub median_mm: f64,
    pub worst_mm: f64,
}

impl PlaceErrors {
    /// `None` of nothing.
    fn of(mut errors_mm: Vec<f64>) -> Option<PlaceErrors> {
        errors_mm.sort_by(f64::total_cmp);
        let worst_mm = *errors_mm.last()?;
        Some(PlaceErrors {
            trials: errors_mm.len(),
            median_mm: errors_mm[(errors_mm.len() - 1) / 2],
            worst_mm,
        })
    }
}

/// A part on the table.
struct Part {
    shown: &'static str,
    /// Whether it was learned.
    known: bool,
    standing: Standing,
}

impl Part {
    fn has_pose(&self) -> bool {
        self.known && self.shown != WITHOUT_POSE
    }

    /// Where the robot finds it.
    fn robot_mm(&self) -> [f64; 2] {
        robot_mm(self.standing.middle_mm())
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
pub fn views() -> Vec<Exemplar> {
    let mut views = Vec::new();
    for (label, thing) in known_things() {
        for turn_deg in (0..360).step_by(STEP_DEG) {
            let choice = |salt: u32| 2.0 * hash(1400 + salt, views.len() as i32, 0) - 1.0;
            let (x_mm, y_mm) = (LEARNED_MM[0] * choice(0), LEARNED_MM[1] * choice(1));
            let standing = Standing { thing: thing.clone(), x_mm, y_mm, turn_deg: turn_deg as f32 };
            let table = Table { things: vec![standing], shade: SHADE };
            let view = overview(x_mm + LEARNED_OFF_MM * choice(2), y_mm + LEARNED_OFF_MM * choice(3));
            let bytes = table.seen(view, (VIEW_PX, VIEW_PX), 5000 + 2 * views.len() as u32);
            let png = png_rgb8(VIEW_PX, VIEW_PX, &bytes);
            views.push(Exemplar { label: label.into(), pose_deg: Some(turn_deg as f64), png });
        }
    }
    views
}

/// What lies on the table: every known thing and a strange one, somewhere, turned somehow.
fn parts() -> Vec<Part> {
    let known = known_things().into_iter().map(|(name, thing)| (name, thing, true));
    let strange = strange_things().into_iter().take(1).map(|(name, thing)| (name, thing, false));
    let place = |(n, (shown, thing, known))| {
        let choice = |salt: u32| hash(1300 + salt, n as i32, 0);
        let off = |axis: usize| OFF_MM[axis] * (2.0 * choice(axis as u32) - 1.0);
        let (column, row) = ((n % COLUMNS) as f32, (n / COLUMNS) as f32);
        let (x_mm, y_mm) = ((column - 1.0) * PART_MM[0] + off(0), (row - 0.5) * PART_MM[1] + off(1));
        let turn_deg = (3600.0 * choice(2)).round() / 10.0;
        Part { shown, known, standing: Standing { thing, x_mm, y_mm, turn_deg } }
    };
    known.chain(strange).enumerate().map(place).collect()
}

fn table(parts: &[Part]) -> Table {
    Table { things: parts.iter().map(|part| part.standing.clone()).collect(), shade: SHADE }
}

fn photographed(table: &Table) -> Vec<u8> {
    png_rgb8(OVERVIEW_PX.0, OVERVIEW_PX.1, &table.seen(overview(0.0, 0.0), OVERVIEW_PX, 6000))
}

/// What the camera at the gripper sees, the gripper being somewhere.
fn seen_from_gripper(table: &Table, gripper_mm: [f64; 2], seed: u32) -> Vec<u8> {
    let [x, y] = table_mm(gripper_mm).map(|at| at as f32);
    let view = View { x, y, turn_deg: LOCAL_TURN_DEG as f32, scale: (1.0 / LOCAL_MM_PER_PX) as f32 };
    png_rgb8(LOCAL_PX.0, LOCAL_PX.1, &table.seen(view, LOCAL_PX, seed))
}

/// The workcell in the words of the contract.
fn workcell() -> Value {
    let touched = |image_px: [f64; 2]| {
        let exactly = |at: f64| (at / TOUCHED_TO_MM).round() * TOUCHED_TO_MM;
        json!({"image_px": image_px, "robot_mm": robot_mm(shown_mm(image_px)).map(exactly)})
    };
    json!({
        "database": DATABASE,
        "correspondences": TOUCHED_PX.map(touched),
        "local": {"mm_per_px": MEASURED_MM_PER_PX, "rotation_deg": ROBOT_TURN_DEG + LOCAL_TURN_DEG},
    })
}

/// Forget the workcell of a run before.
pub async fn forget(server: &Server) -> Result<(), DemoError> {
    server.forget(&["workcells", WORKCELL]).await
}

/// Inspect the table, print a row a part and what came of it all, centre; the pictures go to `folder`.
///
/// # Errors
/// [`DemoError`] when the service doesn't answer or refuses, or a file can't be written.
pub async fn inspect(
    server: &Server,
    version: u64,
    folder: &Path,
    out: &mut dyn Write,
) -> Result<InspectingSummary, DemoError> {
    let parts = parts();
    let table = table(&parts);
    let picture = photographed(&table);
    server.create(&["workcells", WORKCELL], &workcell()).await?;
    let inspected = server.inspect(WORKCELL, version, &picture).await?;
    let annotated = server.inspection_annotated(WORKCELL, &picture).await?;
    let regions = server.regions(&picture, "image/png; preview=regions").await?;
    let labels = server.regions(&picture, "image/png").await?;
    let seen: Vec<Seen> = parts.iter().map(|part| Seen::of(part, &inspected.parts)).collect();
    writeln!(
        out,
        "  {:<8}{:<10}{:>10}{:>8}{:>20}{:>18}{:>8}",
        "part", "answered", "turned by", "truly", "at, robot mm", "truly", "off"
    )?;
    for seen in &seen {
        writeln!(out, "  {}", seen.line())?;
    }

    let middle = seen.iter().find(|seen| seen.part.shown == CENTRED);
    let arrival = middle.map(|seen| (seen.part, seen.said.and_then(|said| said.robot_mm)));
    let mut pictures = vec![
        ("table.png".to_owned(), picture),
        ("annotated.png".to_owned(), annotated),
        ("regions.png".to_owned(), regions),
        ("labels.png".to_owned(), labels),
    ];
    let (mut centring_px, mut centred) = (Vec::new(), false);
    if let Some((part, Some([x, y]))) = arrival {
        let mut gripper_mm = [x + STRAY_MM[0], y + STRAY_MM[1]];
        for moves in 0..=MOVES {
            centring_px.push(apart(gripper_mm, part.robot_mm()) / LOCAL_MM_PER_PX);
            let picture = seen_from_gripper(&table, gripper_mm, 7000 + 2 * moves as u32);
            let answer = server.centre(WORKCELL, &picture).await?;
            pictures.push((format!("gripper-{moves}.png"), picture));
            centred = answer.centred;
            gripper_mm = [0, 1].map(|axis| gripper_mm[axis] + answer.move_mm[axis]);
        }
    }
    keep_in(folder, pictures.iter().map(|(name, png)| (name.clone(), png)))?;
    let summary = InspectingSummary::of(&seen, centring_px, centred);
    summary.tell(inspected.inspect_ms, out)?;
    Ok(summary)
}

/// How to see what stands on the table.
pub fn directions(base_url: &str, folder: &Path, out: &mut dyn Write) -> Result<(), DemoError> {
    let (base_url, file) = (base_url.trim_end_matches('/'), folder.join("table.png"));
    let file = file.display();
    writeln!(
        out,
        "inspect the table, and see what is said of every part:\n  curl -F 'overview=@{file}' \\\n    \
         -H 'Accept: image/png' -o inspected.png '{base_url}/v1/workcells/{WORKCELL}/inspections'"
    )?;
    Ok(())
}

/// A part, and what was said of it.
struct Seen<'a> {
    part: &'a Part,
    /// `None`: it has no region.
    said: Option<&'a InspectedPart>,
}

impl<'a> Seen<'a> {
    fn of(part: &'a Part, said: &'a [InspectedPart]) -> Seen<'a> {
        let at_px = overview_px(part.standing.middle_mm());
        let nearest = said
            .iter()
            .min_by(|a, b| apart(a.centroid_px, at_px).total_cmp(&apart(b.centroid_px, at_px)))
            .filter(|nearest| apart(nearest.centroid_px, at_px) < SAME_PX);
        Seen { part, said: nearest }
    }

    fn label(&self) -> Option<&str> {
        self.said.and_then(|said| said.answer.label.as_deref())
    }

    /// Named as what it is; a strange part: found and not named at all.
    fn is_right(&self) -> bool {
        self.said.is_some() && self.label() == self.part.known.then_some(self.part.shown)
    }

    /// Of a part that is named right and has a pose.
    fn turn_error_deg(&self) -> Option<f64> {
        let pose = self.said.filter(|_| self.part.has_pose() && self.is_right())?.answer.pose?;
        Some(degrees_apart(pose.turn_deg, f64::from(self.part.standing.turn_deg)))
    }

    fn place_error_mm(&self) -> Option<f64> {
        Some(apart(self.said?.robot_mm?, self.part.robot_mm()))
    }

    fn line(&self) -> String {
        let point = |[x, y]: [f64; 2]| format!("({x:.1}, {y:.1})");
        let pose = self.said.and_then(|said| said.answer.pose);
        let said_deg = pose.map_or_else(String::new, |pose| {
            format!("{:.1}°{}", pose.turn_deg, if pose.reliable { "" } else { "?" })
        });
        let true_deg = match self.part.has_pose() {
            true => format!("{:.1}°", self.part.standing.turn_deg),
            false => String::new(),
        };
        let place = self.said.and_then(|said| said.robot_mm).map_or_else(String::new, point);
        let off = self.place_error_mm().map_or_else(String::new, |off_mm| format!("{off_mm:.2}"));
        let named = self.label().unwrap_or("nothing");
        let verdict = if self.is_right() { "right" } else { "WRONG" };
        format!(
            "{:<8}{named:<10}{said_deg:>10}{true_deg:>8}{place:>20}{:>18}{off:>8}  {verdict}",
            self.part.shown,
            point(self.part.robot_mm())
        )
    }
}

impl InspectingSummary {
    fn of(seen: &[Seen], centring_px: Vec<f64>, centred: bool) -> InspectingSummary {
        let (known, strange): (Vec<&Seen>, Vec<&Seen>) = seen.iter().partition(|seen| seen.part.known);
        InspectingSummary {
            found: Rate::among(seen.iter().map(|seen| seen.said.is_some())),
            named_right: Rate::among(known.iter().map(|seen| seen.is_right())),
            strange_refused: Rate::among(strange.iter().map(|seen| seen.is_right())),
            turn_errors: PoseErrors::of(seen.iter().filter_map(Seen::turn_error_deg).collect()),
            place_errors: PlaceErrors::of(seen.iter().filter_map(Seen::place_error_mm).collect()),
            centring_px,
            centred,
        }
    }

    fn tell(&self, inspect_ms: f64, out: &mut dyn Write) -> Result<(), DemoError> {
        let count = |rate: Rate| format!("{} of {}", rate.hits, rate.trials);
        let (found, right, refused) =
            (count(self.found), count(self.named_right), count(self.strange_refused));
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
    use crate::demo::client::{AnsweredPose, ObjectAnswer};
    use landmarkd_core::imaging::{DecodeLimits, Frame, decode};
    use landmarkd_core::recognition::objects::{Canvas, ObjectOptions, Objects, View};
    use landmarkd_core::vision::segmentation::SegmentationOptions;
    use landmarkd_core::workcell::{Correspondence, Mapping, Workcell};

    fn frame(png: &[u8]) -> Frame {
        decode(png, &DecodeLimits::default()).unwrap()
    }

    #[test]
    fn parts_lie_apart_and_wholly_in_the_overview() {
        let parts = parts();
        assert_eq!(parts.iter().map(|part| part.known).collect::<Vec<_>>(), [true, true, true, true, false]);
        for (n, part) in parts.iter().enumerate() {
            let at = |part: &Part| [part.standing.x_mm, part.standing.y_mm].map(f64::from);
            let [x, y] = overview_px(at(part));
            assert!((70.0..570.0).contains(&x) && (70.0..410.0).contains(&y), "{}: {x}, {y}", part.shown);
            for other in &parts[n + 1..] {
                assert!(apart(at(part), at(other)) > 100.0, "{} and {}", part.shown, other.shown);
            }
            let [x, y] = table_mm(part.robot_mm());
            assert!(apart([x, y], part.standing.middle_mm()) < 1e-9, "{}", part.shown);
            let [x, y] = shown_mm(overview_px([x, y]));
            assert!(apart([x, y], part.standing.middle_mm()) < 1e-9, "{}", part.shown);
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
        let part = parts().into_iter().find(|part| part.shown == CENTRED).unwrap();
        let table = Table { things: vec![part.standing.clone()], shade: 0.0 };
        let truth = part.robot_mm();
        let gripper_mm = [truth[0] + STRAY_MM[0], truth[1] + STRAY_MM[1]];
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

    /// What the core says of the overview, with its default options.
    fn core_says(parts: &[Part]) -> Vec<InspectedPart> {
        let options = ObjectOptions { segment: true, ..ObjectOptions::default() };
        let canvas = Canvas::new(&options, (VIEW_PX as u32, VIEW_PX as u32));
        let views = views().into_iter().enumerate().map(|(n, view)| View {
            id: n.to_string(),
            label: view.label,
            pose_deg: view.pose_deg,
            appearance: canvas.appearance(&frame(&view.png)).unwrap(),
        });
        let (model, _) = Objects::train(views.collect(), &canvas, &options).unwrap();
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
        let said = inspection.parts.into_iter().map(|part| {
            let decision = part.recognition.decision;
            let pose = decision.as_ref().and_then(|decision| decision.pose).map(|pose| AnsweredPose {
                turn_deg: pose.turn_deg,
                sigma_deg: pose.sigma_deg,
                reliable: pose.reliable,
            });
            InspectedPart {
                centroid_px: part.region.centroid_px,
                robot_mm: part.robot_mm,
                answer: ObjectAnswer { label: decision.map(|decision| decision.label), pose },
            }
        });
        said.collect()
    }

    #[test]
    fn drawn_parts_are_named_and_placed_and_the_strange_one_is_refused() {
        let parts = parts();
        let said = core_says(&parts);
        let seen: Vec<Seen> = parts.iter().map(|part| Seen::of(part, &said)).collect();
        for seen in &seen {
            println!("{}", seen.line());
        }
        let summary = InspectingSummary::of(&seen, Vec::new(), false);
        assert_eq!((said.len(), summary.found), (5, Rate::of(5, 5)));
        assert_eq!((summary.named_right, summary.strange_refused), (Rate::of(4, 4), Rate::of(1, 1)));
        let (turns, places) = (summary.turn_errors.unwrap(), summary.place_errors.unwrap());
        assert!(turns.worst_deg <= 5.0, "{turns}");
        assert!(places.worst_mm <= 1.0, "{places:?}");
    }

    #[test]
    fn a_summary_counts_each_part_where_it_belongs() {
        let parts = parts();
        let said = |part: &Part, label: Option<&str>, off_mm: f64| {
            let [x, y] = part.robot_mm();
            let turn_deg = f64::from(part.standing.turn_deg) + 2.0;
            InspectedPart {
                centroid_px: overview_px(part.standing.middle_mm()),
                robot_mm: Some([x + off_mm, y]),
                answer: ObjectAnswer {
                    label: label.map(str::to_owned),
                    pose: Some(AnsweredPose { turn_deg, sigma_deg: 1.0, reliable: false }),
                },
            }
        };
        // the house named right, the mug as a house, the truck not found, the vase right, the strange one a mug
        let said = [
            said(&parts[4], Some("mug"), 3.0),
            said(&parts[3], Some(WITHOUT_POSE), 1.0),
            said(&parts[1], Some("house"), 2.0),
            said(&parts[0], Some("house"), 4.0),
        ];
        let seen: Vec<Seen> = parts.iter().map(|part| Seen::of(part, &said)).collect();
        let summary = InspectingSummary::of(&seen, vec![30.0, 1.0], true);
        assert_eq!(summary.found, Rate::of(4, 5));
        assert_eq!(summary.named_right, Rate::of(2, 4));
        assert_eq!(summary.strange_refused, Rate::of(0, 1));
        let turns = summary.turn_errors.unwrap();
        assert_eq!(turns.trials, 1, "the house alone is named right and has a pose");
        assert!((turns.worst_deg - 2.0).abs() < 1e-6, "{turns}");
        let places = summary.place_errors.unwrap();
        assert_eq!(places.trials, 4);
        assert!((places.median_mm - 2.0).abs() < 1e-9 && (places.worst_mm - 4.0).abs() < 1e-9, "{places:?}");
    }
}
