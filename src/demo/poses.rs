//! Poses: a database of things on a turntable is trained from all sides and asked from sides in between, together with
//! things that it was not trained on.

use std::io::Write;
use std::path::Path;

use serde_json::json;

use super::client::{AnsweredPose, Recognition};
use super::data_sets::Exemplar;
use super::drawing::hash;
use super::files::{replace_folder, write_file};
use super::turntable::{SIDE_PX, Thing, WITHOUT_POSE, known_things, unknown_things};
use super::{DemoError, train};
use crate::client::Server;
use crate::evaluate::{PoseErrors, Rate};
use landmarkd_core::angle::angular_distance_deg;
use landmarkd_core::imaging::encode::png_rgb8;

/// The database.
pub const DATABASE: &str = "demo-turntable";
/// From one training view to the next.
const STEP_DEG: usize = 15;
/// Queries of each thing, and of each one that was not trained on.
const KNOWN_QUERIES: usize = 12;
const UNKNOWN_QUERIES: usize = 6;

/// A picture of a thing on the turntable, to recognise.
struct PoseQuery {
    shown: &'static str,
    /// Whether the database was trained on it.
    known: bool,
    turn_deg: f64,
    png: Vec<u8>,
}

/// How often things were named right, and how far their poses were off.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseSummary {
    /// Pictures of known things that were named right.
    pub named_right: Rate,
    /// Answers that call their pose reliable, of those that named a thing right which has a pose.
    pub reliable: Rate,
    /// Errors of all poses that call themselves reliable, whatever the thing named right; `None` without any.
    pub reliable_errors: Option<PoseErrors>,
    /// Answers that named the thing of revolution right and claim no reliable pose.
    pub without_pose: Rate,
    /// Pictures of things not trained on that were answered "unknown".
    pub unknown_refused: Rate,
}

fn png(thing: &Thing, turn_deg: f64, seed: u32) -> Vec<u8> {
    png_rgb8(SIDE_PX, SIDE_PX, &thing.draw(turn_deg as f32, seed))
}

/// Every known thing from all sides.
fn views() -> Vec<Exemplar> {
    let mut views = Vec::new();
    for (label, thing) in known_things() {
        for turn_deg in (0..360).step_by(STEP_DEG).map(|turn_deg| turn_deg as f64) {
            let png = png(&thing, turn_deg, 2000 + 2 * views.len() as u32);
            views.push(Exemplar { label: label.into(), pose_deg: Some(turn_deg), png });
        }
    }
    views
}

/// Known and unknown things, each from sides that lie between training views.
fn queries() -> Vec<PoseQuery> {
    let known = known_things().into_iter().map(|(name, thing)| (name, thing, true));
    let unknown = unknown_things().into_iter().map(|(name, thing)| (name, thing, false));
    let mut queries = Vec::new();
    for (n, (shown, thing, known)) in known.chain(unknown).enumerate() {
        let count = if known { KNOWN_QUERIES } else { UNKNOWN_QUERIES };
        for k in 0..count {
            let choice = |salt: u32| f64::from(hash(1100 + salt, n as i32, k as i32));
            // one of the gaps between training views in each part of the circle, and a place within it
            let gaps = 360 / STEP_DEG / count;
            let gap = k * gaps + (gaps as f64 * choice(0)) as usize;
            let within_deg = 1.0 + (STEP_DEG as f64 - 2.0) * choice(1);
            let turn_deg = (10.0 * ((gap * STEP_DEG) as f64 + within_deg)).round() / 10.0;
            let png = png(&thing, turn_deg, 3000 + 2 * queries.len() as u32);
            queries.push(PoseQuery { shown, known, turn_deg, png });
        }
    }
    queries
}

/// Trains, asks, prints; keeps all pictures below `pictures_dir`, as `evaluate` takes them too.
///
/// # Errors
/// [`DemoError`] when the service doesn't answer or refuses, or a file can't be written.
pub async fn show(
    server: &Server,
    pictures_dir: &Path,
    out: &mut dyn Write,
) -> Result<PoseSummary, DemoError> {
    let (views, queries) = (views(), queries());
    let folder = pictures_dir.join(DATABASE);
    let named = |label: &str, turn_deg: f64| format!("{label}/turned__{turn_deg}.png");
    let learned = views.iter().map(|view| (named(&view.label, view.pose_deg.unwrap_or_default()), &view.png));
    let asked = queries.iter().map(|query| (named(query.shown, query.turn_deg), &query.png));
    replace_folder(&folder.join("learned"), learned)?;
    replace_folder(&folder.join("asked"), asked)?;
    let version = train(server, DATABASE, &json!({"kind": "objects"}), &views, out).await?;
    // A second version, for the console's page that compares two.
    server.train(DATABASE, &json!({"options": {"dimension": 6}, "promote": "never"})).await?;

    let mut answered = Vec::new();
    for query in &queries {
        let answer = server.recognise(DATABASE, version, &query.png).await?;
        answered.push(Answered { query, answer });
    }
    print_rows(&answered, out)?;
    let summary = PoseSummary::of(&answered);
    summary.print(out)?;
    if let Some(example) = answered.iter().find(|answered| answered.query.shown == EXAMPLE) {
        writeln!(out, "  {}", example_line(example))?;
        let annotated = server.annotated(DATABASE, &example.query.png).await?;
        write_file(&folder.join("annotated.png"), &annotated)?;
    }
    Ok(summary)
}

/// Prints a row a thing, and a line a wrong answer.
fn print_rows(answered: &[Answered], out: &mut dyn Write) -> Result<(), DemoError> {
    let [named_right, reliable] = ["named right", "pose reliable"];
    writeln!(out, "  {:<28}{named_right:<20}{reliable:<20}pose error of these", "thing, turned")?;
    for (name, _) in known_things() {
        let of_thing: Vec<&Answered> = answered.iter().filter(|a| a.query.shown == name).collect();
        let right = Rate::among(of_thing.iter().map(|a| a.is_right())).counts();
        let reliable =
            Rate::among(of_thing.iter().filter(|a| a.is_right()).map(|a| a.is_reliable())).counts();
        let errors = reliable_errors(of_thing).map_or_else(
            || "none".to_owned(),
            |errors| format!("median {:.1}°, worst {:.1}°", errors.median_deg, errors.worst_deg),
        );
        writeln!(out, "  {name:<28}{right:<20}{reliable:<20}{errors}")?;
    }
    for wrong in answered.iter().filter(|a| !a.is_right()) {
        let PoseQuery { shown, turn_deg, .. } = wrong.query;
        let named = wrong.answer.label().unwrap_or("nothing");
        writeln!(out, "  WRONG: {shown} turned by {turn_deg}° taken for {named}")?;
    }
    Ok(())
}

/// The thing whose first answer is printed in a line and kept as a picture: one that has a pose.
const EXAMPLE: &str = "truck";

fn example_line(Answered { query, answer }: &Answered) -> String {
    let PoseQuery { shown, turn_deg, .. } = query;
    let named = answer.label().unwrap_or("nothing that is known");
    let pose = match answer.pose {
        None => "without a pose".to_owned(),
        Some(AnsweredPose { turn_deg, sigma_deg, reliable }) => {
            let trust = if reliable { "reliable" } else { "not reliable" };
            format!("turned by {turn_deg:.1}° ± {sigma_deg:.1}°, {trust}")
        }
    };
    format!("the {shown} turned by {turn_deg}° is answered: {named}, {pose}")
}

/// A query and its answer.
struct Answered<'a> {
    query: &'a PoseQuery,
    answer: Recognition,
}

impl Answered<'_> {
    /// Named as what it is; a thing not trained on: answered "unknown".
    fn is_right(&self) -> bool {
        self.answer.label() == self.query.known.then_some(self.query.shown)
    }

    fn is_reliable(&self) -> bool {
        self.answer.pose.is_some_and(|pose| pose.reliable)
    }
}

fn reliable_errors<'a>(answered: impl IntoIterator<Item = &'a Answered<'a>>) -> Option<PoseErrors> {
    let reliable = answered.into_iter().filter(|a| a.query.known && a.is_right() && a.is_reliable());
    let errors_deg = reliable
        .filter_map(|a| a.answer.pose.map(|pose| angular_distance_deg(pose.turn_deg, a.query.turn_deg)));
    PoseErrors::of(errors_deg.collect())
}

impl PoseSummary {
    fn of(answered: &[Answered]) -> PoseSummary {
        let (known, unknown): (Vec<&Answered>, Vec<&Answered>) = answered.iter().partition(|a| a.query.known);
        let right = || known.iter().copied().filter(|a| a.is_right());
        let has_pose = |a: &&Answered| a.query.shown != WITHOUT_POSE;
        PoseSummary {
            named_right: Rate::among(known.iter().map(|a| a.is_right())),
            reliable: Rate::among(right().filter(has_pose).map(Answered::is_reliable)),
            reliable_errors: reliable_errors(known.iter().copied()),
            without_pose: Rate::among(right().filter(|a| !has_pose(a)).map(|a| !a.is_reliable())),
            unknown_refused: Rate::among(unknown.iter().map(|a| a.is_right())),
        }
    }

    fn print(&self, out: &mut dyn Write) -> Result<(), DemoError> {
        writeln!(out, "  named right: {}", self.named_right.counts())?;
        if let Some(PoseErrors { trials, median_deg, worst_deg, .. }) = self.reliable_errors {
            writeln!(out, "  pose called reliable: {} of things that have one", self.reliable.counts())?;
            writeln!(
                out,
                "  pose error of {trials} reliable answers: median {median_deg:.1}°, worst {worst_deg:.1}°"
            )?;
        }
        let claims = self.without_pose.counts();
        writeln!(
            out,
            "  the {WITHOUT_POSE} looks the same from all sides: {claims} answers call no pose reliable"
        )?;
        let names: Vec<&str> = unknown_things().into_iter().map(|(name, _)| name).collect();
        let refused = self.unknown_refused.counts();
        Ok(writeln!(out, "  never learned ({}): {refused} refused", names.join(", "))?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::client::Decision;
    use landmarkd_core::imaging::{DecodeLimits, Frame, decode};
    use landmarkd_core::recognition::objects::{
        Normaliser, ObjectOptions, View, ViewName, common_step_deg, train,
    };

    fn frame(png: &[u8]) -> Frame {
        decode(png, &DecodeLimits::default()).unwrap()
    }

    fn named(label: &str) -> Decision {
        Decision { label: label.to_owned(), confidence: None }
    }

    /// The core's answers with its default options.
    fn core_answers(queries: &[PoseQuery]) -> Vec<Answered<'_>> {
        let options = ObjectOptions::default();
        let views = views();
        let posed = views.iter().map(|view| (view.label.as_str(), view.pose_deg));
        let normaliser =
            Normaliser::new(&options, (SIDE_PX as u32, SIDE_PX as u32)).with_step_deg(common_step_deg(posed));
        let views = views.into_iter().enumerate().map(|(n, view)| {
            let name = ViewName { id: n.to_string(), label: view.label, pose_deg: view.pose_deg };
            View::new(&normaliser, name, &frame(&view.png), true).unwrap()
        });
        let (model, _) = train(views.collect(), &normaliser, &options).unwrap();
        let answer = |query: &PoseQuery| {
            let decision = model.recognise(&frame(&query.png), |_| ()).unwrap().decision;
            let pose = decision.as_ref().and_then(|decision| decision.pose).map(|pose| AnsweredPose {
                turn_deg: pose.turn_deg,
                sigma_deg: pose.sigma_deg,
                reliable: pose.reliable,
            });
            Recognition {
                decision: decision.map(|decision| named(&decision.label)),
                pose,
                ..Recognition::default()
            }
        };
        queries.iter().map(|query| Answered { query, answer: answer(query) }).collect()
    }

    #[test]
    fn drawn_things_are_named_with_their_turn_and_unknown_ones_are_refused() {
        let queries = queries();
        let answered = core_answers(&queries);
        for answer in &answered {
            println!("{}", example_line(answer));
        }
        let summary = PoseSummary::of(&answered);
        assert!(summary.named_right.hits >= 46, "of 48: {summary:?}");
        assert!(summary.unknown_refused.hits >= 11, "of 12: {summary:?}");
        assert_eq!(summary.without_pose.hits, summary.without_pose.trials, "{summary:?}");
        assert!(summary.reliable.rate >= 0.6, "{summary:?}");
        let errors = summary.reliable_errors.unwrap();
        assert!(errors.median_deg <= 2.0 && errors.worst_deg <= 8.0, "{errors}");
    }

    #[test]
    fn no_query_is_a_training_view_and_each_part_of_the_circle_has_one() {
        let queries = queries();
        for (name, count) in
            [("mug", KNOWN_QUERIES), (WITHOUT_POSE, KNOWN_QUERIES), ("lamp", UNKNOWN_QUERIES)]
        {
            let turns: Vec<f64> = queries.iter().filter(|q| q.shown == name).map(|q| q.turn_deg).collect();
            assert_eq!(turns.len(), count, "{name}");
            for (k, turn_deg) in turns.iter().enumerate() {
                let part_deg = 360.0 / count as f64;
                assert!(
                    (part_deg * k as f64..part_deg * (k + 1) as f64).contains(turn_deg),
                    "{name}: {turns:?}"
                );
                let aside = turn_deg % STEP_DEG as f64;
                assert!((1.0..=STEP_DEG as f64 - 1.0).contains(&aside), "{name}: {turns:?}");
            }
        }
        assert_eq!(views().len(), 4 * 24);
    }

    #[test]
    fn a_summary_counts_each_answer_where_it_belongs() {
        let query = |shown, known| PoseQuery { shown, known, turn_deg: 359.0, png: Vec::new() };
        let answer = |label: &str, turn_deg, reliable| Recognition {
            decision: Some(named(label)),
            pose: Some(AnsweredPose { turn_deg, sigma_deg: 1.0, reliable }),
            ..Recognition::default()
        };
        let nothing = Recognition::default;
        let (mug, vase, lamp) = (query("mug", true), query(WITHOUT_POSE, true), query("lamp", false));
        let answered = [
            (&mug, answer("mug", 1.0, true)),
            (&mug, answer("mug", 90.0, false)),
            (&mug, answer("house", 359.0, true)),
            (&vase, answer(WITHOUT_POSE, 10.0, false)),
            (&vase, nothing()),
            (&lamp, nothing()),
            (&lamp, answer(WITHOUT_POSE, 10.0, true)),
        ]
        .map(|(query, answer)| Answered { query, answer });
        let expected = PoseSummary {
            named_right: Rate::of(3, 5),
            reliable: Rate::of(1, 2),
            reliable_errors: PoseErrors::of(vec![2.0]),
            without_pose: Rate::of(1, 1),
            unknown_refused: Rate::of(1, 2),
        };
        assert_eq!(PoseSummary::of(&answered), expected);
    }
}
