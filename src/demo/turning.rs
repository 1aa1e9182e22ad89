//! The third act: things on a turntable are learned from all sides and asked about from sides in between, together
//! with things that were never learned. Which is it, and how is it turned?

use std::io::Write;

use super::DemoError;
use super::client::{AnsweredPose, ObjectAnswer, Server};
use super::drawing::hash;
use super::lessons::Exemplar;
use super::turntable::{SIDE_PX, Thing, WITHOUT_POSE, known_things, strange_things};
use crate::evaluate::{PoseErrors, Rate, degrees_apart};
use landmarkd_core::imaging::encode::png_rgb8;

/// The database of the third act.
pub const DATABASE: &str = "demo-turntable";
/// From one learned view to the next.
const STEP_DEG: usize = 15;
/// How often each thing is asked about, and each strange one.
const KNOWN_QUESTIONS: usize = 12;
const STRANGE_QUESTIONS: usize = 6;

/// A picture of a thing on the turntable that is asked about.
pub struct TurnedQuestion {
    /// What it shows.
    pub shown: &'static str,
    /// Whether that was learned.
    pub known: bool,
    pub turn_deg: f64,
    pub png: Vec<u8>,
}

/// How the third act went.
#[derive(Clone, Debug, PartialEq)]
pub struct TurningSummary {
    /// Pictures of known things that were named right.
    pub named_right: Rate,
    /// Answers that call their pose reliable, of those that named a thing right which has a pose.
    pub reliable: Rate,
    /// Errors of all poses that call themselves reliable, whatever the thing named right; `None` without any.
    pub reliable_errors: Option<PoseErrors>,
    /// Answers that named the thing of revolution right and claim no reliable pose.
    pub without_pose: Rate,
    /// Pictures of things never learned that were refused.
    pub strange_refused: Rate,
}

fn png(thing: &Thing, turn_deg: f64, seed: u32) -> Vec<u8> {
    png_rgb8(SIDE_PX, SIDE_PX, &thing.draw(turn_deg as f32, seed))
}

/// Every known thing from all sides.
pub fn views() -> Vec<Exemplar> {
    let mut views = Vec::new();
    for (label, thing) in known_things() {
        for turn_deg in (0..360).step_by(STEP_DEG).map(|turn_deg| turn_deg as f64) {
            let png = png(&thing, turn_deg, 2000 + 2 * views.len() as u32);
            views.push(Exemplar { label: label.into(), pose_deg: Some(turn_deg), png });
        }
    }
    views
}

/// Known things and strange ones, each from sides that lie between learned views.
pub fn questions() -> Vec<TurnedQuestion> {
    let known = known_things().into_iter().map(|(name, thing)| (name, thing, true));
    let strange = strange_things().into_iter().map(|(name, thing)| (name, thing, false));
    let mut questions = Vec::new();
    for (n, (shown, thing, known)) in known.chain(strange).enumerate() {
        let count = if known { KNOWN_QUESTIONS } else { STRANGE_QUESTIONS };
        for k in 0..count {
            let choice = |salt: u32| f64::from(hash(1100 + salt, n as i32, k as i32));
            // one of the gaps between learned views in each part of the circle, and a place within it
            let gaps = 360 / STEP_DEG / count;
            let gap = k * gaps + (gaps as f64 * choice(0)) as usize;
            let within_deg = 1.0 + (STEP_DEG as f64 - 2.0) * choice(1);
            let turn_deg = (10.0 * ((gap * STEP_DEG) as f64 + within_deg)).round() / 10.0;
            let png = png(&thing, turn_deg, 3000 + 2 * questions.len() as u32);
            questions.push(TurnedQuestion { shown, known, turn_deg, png });
        }
    }
    questions
}

/// Ask every question, print a row a thing, and what came of it all.
pub async fn examine(
    server: &Server,
    version: u64,
    questions: &[TurnedQuestion],
    out: &mut dyn Write,
) -> Result<TurningSummary, DemoError> {
    let mut answered = Vec::new();
    for question in questions {
        let answer = server.ask_object(DATABASE, version, &question.png).await?;
        answered.push(Answered { question, answer });
    }
    writeln!(
        out,
        "  {:<28}{:<20}{:<20}pose error of these",
        "thing, turned", "named right", "pose reliable"
    )?;
    for (name, _) in known_things() {
        let of_thing: Vec<&Answered> = answered.iter().filter(|a| a.question.shown == name).collect();
        let right = Rate::among(of_thing.iter().map(|a| a.is_right()));
        let reliable = Rate::among(of_thing.iter().filter(|a| a.is_right()).map(|a| a.is_reliable()));
        let errors = reliable_errors(of_thing);
        let told = errors.map_or_else(
            || "none".to_owned(),
            |errors| format!("median {:.1}°, worst {:.1}°", errors.median_deg, errors.worst_deg),
        );
        writeln!(out, "  {name:<28}{:<20}{:<20}{told}", count(right), count(reliable))?;
    }
    for wrong in answered.iter().filter(|a| !a.is_right()) {
        let TurnedQuestion { shown, turn_deg, .. } = wrong.question;
        let named = wrong.answer.label.as_deref().unwrap_or("nothing");
        writeln!(out, "  WRONG: {shown} turned by {turn_deg}° taken for {named}")?;
    }
    let summary = TurningSummary::of(&answered);
    let TurningSummary { named_right, reliable, reliable_errors, without_pose, strange_refused } = &summary;
    writeln!(out, "  named right: {}", count(*named_right))?;
    if let Some(PoseErrors { trials, median_deg, worst_deg, .. }) = reliable_errors {
        let called = count(*reliable);
        writeln!(out, "  pose called reliable: {called} of things that have one")?;
        writeln!(
            out,
            "  pose error of {trials} reliable answers: median {median_deg:.1}°, worst {worst_deg:.1}°"
        )?;
    }
    let claims = count(*without_pose);
    writeln!(
        out,
        "  the {WITHOUT_POSE} looks the same from all sides: {claims} answers call no pose reliable"
    )?;
    let names: Vec<&str> = strange_things().into_iter().map(|(name, _)| name).collect();
    writeln!(out, "  never learned ({}): {} refused", names.join(", "), count(*strange_refused))?;
    if let Some(example) = example(questions).and_then(|n| answered.get(n)) {
        writeln!(out, "  {}", example_line(example))?;
    }
    Ok(summary)
}

/// Which question's answer is told in a line and kept as a picture: one about a thing that has a pose.
pub fn example(questions: &[TurnedQuestion]) -> Option<usize> {
    questions.iter().position(|question| question.shown == "truck")
}

fn example_line(Answered { question, answer }: &Answered) -> String {
    let TurnedQuestion { shown, turn_deg, .. } = question;
    let named = answer.label.as_deref().unwrap_or("nothing that is known");
    let pose = match answer.pose {
        None => "without a pose".to_owned(),
        Some(AnsweredPose { turn_deg, sigma_deg, reliable }) => {
            let trust = if reliable { "reliable" } else { "not reliable" };
            format!("turned by {turn_deg:.1}° ± {sigma_deg:.1}°, {trust}")
        }
    };
    format!("the {shown} turned by {turn_deg}° is answered: {named}, {pose}")
}

fn count(rate: Rate) -> String {
    format!("{} of {}", rate.hits, rate.trials)
}

struct Answered<'a> {
    question: &'a TurnedQuestion,
    answer: ObjectAnswer,
}

impl Answered<'_> {
    /// Named as what it is; a strange thing: not named at all.
    fn is_right(&self) -> bool {
        self.answer.label.as_deref() == self.question.known.then_some(self.question.shown)
    }

    fn is_reliable(&self) -> bool {
        self.answer.pose.is_some_and(|pose| pose.reliable)
    }
}

fn reliable_errors<'a>(answered: impl IntoIterator<Item = &'a Answered<'a>>) -> Option<PoseErrors> {
    let reliable = answered.into_iter().filter(|a| a.question.known && a.is_right() && a.is_reliable());
    let errors_deg =
        reliable.filter_map(|a| a.answer.pose.map(|pose| degrees_apart(pose.turn_deg, a.question.turn_deg)));
    PoseErrors::of(errors_deg.collect())
}

impl TurningSummary {
    fn of(answered: &[Answered]) -> TurningSummary {
        let (known, strange): (Vec<&Answered>, Vec<&Answered>) =
            answered.iter().partition(|a| a.question.known);
        let right = || known.iter().copied().filter(|a| a.is_right());
        let has_pose = |a: &&Answered| a.question.shown != WITHOUT_POSE;
        TurningSummary {
            named_right: Rate::among(known.iter().map(|a| a.is_right())),
            reliable: Rate::among(right().filter(has_pose).map(Answered::is_reliable)),
            reliable_errors: reliable_errors(known.iter().copied()),
            without_pose: Rate::among(right().filter(|a| !has_pose(a)).map(|a| !a.is_reliable())),
            strange_refused: Rate::among(strange.iter().map(|a| a.is_right())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::imaging::{DecodeLimits, Frame, decode};
    use landmarkd_core::recognition::objects::{Canvas, ObjectOptions, Objects, View};

    fn frame(png: &[u8]) -> Frame {
        decode(png, &DecodeLimits::default()).unwrap()
    }

    /// The core's answers with its default options.
    fn core_answers(questions: &[TurnedQuestion]) -> Vec<Answered<'_>> {
        let options = ObjectOptions::default();
        let canvas = Canvas::new(&options, (SIDE_PX as u32, SIDE_PX as u32));
        let views = views().into_iter().enumerate().map(|(n, view)| View {
            id: n.to_string(),
            label: view.label,
            pose_deg: view.pose_deg,
            appearance: canvas.appearance(&frame(&view.png)).unwrap(),
        });
        let (model, _) = Objects::train(views.collect(), &canvas, &options).unwrap();
        let answer = |question: &TurnedQuestion| {
            let decision = model.recognise(&frame(&question.png), |_| ()).unwrap().decision;
            let pose = decision.as_ref().and_then(|decision| decision.pose).map(|pose| AnsweredPose {
                turn_deg: pose.turn_deg,
                sigma_deg: pose.sigma_deg,
                reliable: pose.reliable,
            });
            ObjectAnswer { label: decision.map(|decision| decision.label), pose }
        };
        questions.iter().map(|question| Answered { question, answer: answer(question) }).collect()
    }

    #[test]
    fn drawn_things_are_named_with_their_turn_and_strange_ones_are_refused() {
        let questions = questions();
        let answered = core_answers(&questions);
        for answer in &answered {
            println!("{}", example_line(answer));
        }
        let summary = TurningSummary::of(&answered);
        assert!(summary.named_right.hits >= 46, "of 48: {summary:?}");
        assert!(summary.strange_refused.hits >= 11, "of 12: {summary:?}");
        assert_eq!(summary.without_pose.hits, summary.without_pose.trials, "{summary:?}");
        assert!(summary.reliable.rate >= 0.6, "{summary:?}");
        let errors = summary.reliable_errors.unwrap();
        assert!(errors.median_deg <= 2.0 && errors.worst_deg <= 8.0, "{errors}");
    }

    #[test]
    fn no_question_is_a_learned_view_and_each_part_of_the_circle_has_one() {
        let questions = questions();
        for (name, count) in
            [("mug", KNOWN_QUESTIONS), (WITHOUT_POSE, KNOWN_QUESTIONS), ("lamp", STRANGE_QUESTIONS)]
        {
            let turns: Vec<f64> = questions.iter().filter(|q| q.shown == name).map(|q| q.turn_deg).collect();
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
        let question = |shown, known| TurnedQuestion { shown, known, turn_deg: 359.0, png: Vec::new() };
        let answer = |label: &str, turn_deg, reliable| ObjectAnswer {
            label: Some(label.to_owned()),
            pose: Some(AnsweredPose { turn_deg, sigma_deg: 1.0, reliable }),
        };
        let nothing = || ObjectAnswer { label: None, pose: None };
        let (mug, vase, lamp) =
            (question("mug", true), question(WITHOUT_POSE, true), question("lamp", false));
        let answered = [
            (&mug, answer("mug", 1.0, true)),
            (&mug, answer("mug", 90.0, false)),
            (&mug, answer("house", 359.0, true)),
            (&vase, answer(WITHOUT_POSE, 10.0, false)),
            (&vase, nothing()),
            (&lamp, nothing()),
            (&lamp, answer(WITHOUT_POSE, 10.0, true)),
        ]
        .map(|(question, answer)| Answered { question, answer });
        let expected = TurningSummary {
            named_right: Rate::of(3, 5),
            reliable: Rate::of(1, 2),
            reliable_errors: PoseErrors::of(vec![2.0]),
            without_pose: Rate::of(1, 1),
            strange_refused: Rate::of(1, 2),
        };
        assert_eq!(TurningSummary::of(&answered), expected);
    }
}
