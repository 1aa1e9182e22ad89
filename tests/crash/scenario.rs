//! One of everything that changes what is kept, and what must hold of it afterwards.
//!
//! A fact is what an address must answer from the moment that its change was acknowledged until the next change of it is
//! asked for; between asking and acknowledgement either truth will do, and there is no fact.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use bytes::Bytes;
use futures_util::StreamExt;
use reqwest::Method;
use serde_json::{Value, json};

use crate::client::{Answer, Client, Died, verify};
use crate::pictures::scene_png;

#[derive(Debug, Clone)]
pub enum Fact {
    /// 404.
    Gone,
    /// 200 with exactly these bytes.
    Bytes(Bytes),
    /// 200 with these members among others.
    Has(Value),
}

/// What was acknowledged, by address; and what each digest answered.
#[derive(Debug, Clone, Default)]
pub struct Known {
    pub facts: BTreeMap<String, Fact>,
    pub answers: BTreeMap<String, Value>,
}

/// What is done about a 503: wait, and perhaps heal the disk.
pub type Patience<'a> = &'a (dyn Fn() + Send + Sync);

/// The picture that is asked about.
const ASKED: u64 = 1;

/// How long a call may be refused before the service counts as not healing.
const HEALS_WITHIN: Duration = Duration::from_secs(30);

/// Does the scenario against a process and notes what it acknowledges.
pub struct Robot<'a> {
    pub client: Client,
    pub known: Known,
    /// Called when a call is answered by 503; none where no call may be.
    pub refused: Option<Patience<'a>>,
    /// Whether this process has answered before, and so must go on answering.
    has_asked: bool,
}

impl<'a> Robot<'a> {
    pub fn new(client: Client, known: Known, refused: Option<Patience<'a>>) -> Self {
        Self { client, known, refused, has_asked: false }
    }

    /// The whole scenario, or as much of it as the process lives for. It does no harm to what it did before.
    pub async fn run(&mut self) -> Result<(), Died> {
        let quick = json!({"kind": "landmarks", "options": {"method": "paper", "interest_points": 8}});
        self.put("/v1/databases/lab", quick.clone()).await?;
        self.known.facts.insert("/v1/databases/lab".into(), Fact::Has(json!({"kind": "landmarks"})));
        let mut ids = Vec::new();
        for number in 1..=3 {
            ids.push(self.upload("lab", number).await?);
        }
        self.batch("lab", 4..=5).await?;
        self.train("lab").await?;
        self.recognise("lab").await?;
        self.upload("lab", 6).await?;
        let second = self.train("lab").await?;
        self.recognise("lab").await?;
        self.alias("lab", 1).await?;
        self.recognise("lab").await?;
        self.delete(&format!("/v1/databases/lab/exemplars/{}", ids[0]), Some("/image")).await?;
        if second != 1 {
            self.delete(&format!("/v1/databases/lab/versions/{second}"), None).await?;
        }
        let optics = json!({"optics": {
            "focal_length_mm": 25, "f_number": 2.8, "near_focus_mm": 529, "plane_separation_mm": 0.37,
            "pixel_pitch_um": 29, "telecentric": true,
        }});
        self.keep("/v1/calibrations/rig", optics["optics"].clone()).await?;
        self.put("/v1/databases/parts", json!({"kind": "objects"})).await?;
        self.keep("/v1/workcells/bench", json!({"database": "parts", "correspondences": [
            {"image_px": [10, 10], "robot_mm": [105, 295]}, {"image_px": [310, 12], "robot_mm": [255, 294]},
            {"image_px": [8, 230], "robot_mm": [104, 185]}, {"image_px": [305, 225], "robot_mm": [252.5, 187.5]},
        ]}))
        .await?;
        let artifact = self.artifact("lab", 1).await?;
        self.put("/v1/databases/spare", quick).await?;
        self.import("spare", artifact).await?;
        self.alias("spare", 1).await?;
        self.recognise("spare").await?;
        self.put("/v1/databases/old", json!({"kind": "landmarks"})).await?;
        self.upload("old", 9).await?;
        self.delete("/v1/databases/old", None).await?;
        Ok(())
    }

    /// Ask until it isn't refused; what it answers is then well, or `None` when it was done already.
    async fn ask(
        &mut self,
        method: Method,
        path: &str,
        with: impl Fn(reqwest::RequestBuilder) -> reqwest::RequestBuilder,
    ) -> Result<Answer, Died> {
        let started = Instant::now();
        let mut asked = 0;
        loop {
            asked += 1;
            let answer = self.client.send(method.clone(), path, &with).await?;
            if answer.status != 503 {
                return Ok(answer);
            }
            let body = answer.json();
            let refused = self.refused.unwrap_or_else(|| panic!("{method} {path} was refused: {body:#}"));
            assert!(answer.retry_after.is_some(), "{body:#}");
            let code = body["code"].as_str().unwrap_or_default();
            assert!(
                ["catalogue_unavailable", "blobs_unavailable"].contains(&code),
                "{method} {path}: {body:#}"
            );
            assert!(
                started.elapsed() < HEALS_WITHIN,
                "{method} {path} doesn't heal, asked {asked} times: {body:#}"
            );
            // What is in memory goes on answering.
            if self.has_asked {
                let asked =
                    self.client.post_picture("/v1/databases/lab/recognitions", scene_png(ASKED)).await?;
                assert_eq!(asked.status, 200, "{:#}", asked.json());
                self.is_as_before(&asked.json());
            }
            refused();
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }

    /// From here on, until it is acknowledged, either truth will do.
    fn open(&mut self, path: &str) {
        self.known.facts.remove(path);
    }

    async fn put(&mut self, path: &str, body: Value) -> Result<Value, Died> {
        self.open(path);
        let answer = self.ask(Method::PUT, path, |request| request.json(&body)).await?;
        assert!(answer.is_well(), "PUT {path}: {:#}", answer.json());
        Ok(answer.json())
    }

    /// A document that reads back as it was answered.
    async fn keep(&mut self, path: &str, body: Value) -> Result<(), Died> {
        let kept = self.put(path, body).await?;
        self.known.facts.insert(path.into(), Fact::Has(kept));
        Ok(())
    }

    pub async fn upload(&mut self, database: &str, number: u64) -> Result<String, Died> {
        let picture = scene_png(number);
        let path = format!("/v1/databases/{database}/exemplars?label=place-{number}");
        let answer = self
            .ask(Method::POST, &path, |request| {
                request.header("content-type", "image/png").body(picture.clone())
            })
            .await?;
        assert!(answer.is_well(), "{:#}", answer.json());
        let id = answer.json()["id"].as_str().unwrap().to_owned();
        self.known
            .facts
            .insert(format!("/v1/databases/{database}/exemplars/{id}/image"), Fact::Bytes(picture));
        Ok(id)
    }

    async fn batch(&mut self, database: &str, numbers: std::ops::RangeInclusive<u64>) -> Result<(), Died> {
        let path = format!("/v1/databases/{database}/exemplars:batch");
        let name = |number: u64| format!("{number}.png");
        let line = |number| json!({"file": name(number), "label": format!("place-{number}")});
        let manifest: Vec<Value> = numbers.clone().map(line).collect();
        let mut left = HEALS_WITHIN.as_millis() / 20;
        loop {
            let answer = self
                .ask(Method::POST, &path, |request| {
                    let mut form =
                        reqwest::multipart::Form::new().text("manifest", json!(manifest).to_string());
                    for number in numbers.clone() {
                        let picture = reqwest::multipart::Part::bytes(scene_png(number).to_vec());
                        form = form.part(name(number), picture.file_name(name(number)));
                    }
                    request.multipart(form)
                })
                .await?;
            let body = answer.json();
            assert!(answer.is_well(), "{body:#}");
            let mut is_whole = true;
            for (item, number) in body["items"].as_array().unwrap().iter().zip(numbers.clone()) {
                match item["id"].as_str() {
                    Some(id) => {
                        let at = format!("/v1/databases/{database}/exemplars/{id}/image");
                        self.known.facts.insert(at, Fact::Bytes(scene_png(number)));
                    }
                    None => is_whole = false,
                }
            }
            if is_whole {
                return Ok(());
            }
            // A part that was refused says so itself; the batch is sent again as its client would.
            let refused = self.refused.unwrap_or_else(|| panic!("{body:#}"));
            refused();
            left -= 1;
            assert!(left > 0, "the batch doesn't heal: {body:#}");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }

    pub async fn train(&mut self, database: &str) -> Result<i64, Died> {
        let current = format!("/v1/databases/{database}/aliases/current");
        self.open(&current);
        let path = format!("/v1/databases/{database}/trainings");
        let answer = self.ask(Method::POST, &path, |request| request.json(&json!({}))).await?;
        assert_eq!(answer.status, 202, "{:#}", answer.json());
        let id = answer.json()["id"].as_str().unwrap().to_owned();
        self.known.facts.insert(format!("/v1/jobs/{id}"), Fact::Has(json!({"state": "succeeded"})));
        let job = loop {
            match tokio::time::timeout(Duration::from_secs(3), self.client.ended(&id)).await {
                Ok(ended) => break ended?,
                // With the disk away no job ends: that is the time to heal.
                Err(_) => self.refused.inspect(|refused| refused()),
            };
        };
        assert_eq!(job["state"], "succeeded", "{job:#}");
        let version = job["version"].as_i64().unwrap();
        let shown = self.shown(&format!("/v1/databases/{database}/versions/{version}")).await?;
        let digest = json!({"digest": shown["digest"]});
        self.known.facts.insert(format!("/v1/databases/{database}/versions/{version}"), Fact::Has(digest));
        self.known.facts.insert(current, Fact::Has(json!({"version": version})));
        Ok(version)
    }

    async fn shown(&mut self, path: &str) -> Result<Value, Died> {
        let answer = self.ask(Method::GET, path, |request| request).await?;
        assert_eq!(answer.status, 200, "{path}: {:#}", answer.json());
        Ok(answer.json())
    }

    async fn alias(&mut self, database: &str, version: i64) -> Result<(), Died> {
        let path = format!("/v1/databases/{database}/aliases/current");
        let kept = self.put(&path, json!({"version": version})).await?;
        assert_eq!(kept["version"], version);
        self.known.facts.insert(path, Fact::Has(json!({"version": version})));
        Ok(())
    }

    /// Delete what is at the path; `shown` is where it is seen below it.
    async fn delete(&mut self, path: &str, shown: Option<&str>) -> Result<(), Died> {
        let gone: Vec<String> =
            self.known.facts.keys().filter(|at| is_at_or_below(at, path)).cloned().collect();
        for at in gone {
            self.open(&at);
        }
        let answer = self.ask(Method::DELETE, path, |request| request).await?;
        // 404: a refused attempt had done it.
        assert!([204, 404].contains(&answer.status), "DELETE {path}: {:#}", answer.json());
        self.known.facts.insert(format!("{path}{}", shown.unwrap_or_default()), Fact::Gone);
        Ok(())
    }

    async fn artifact(&mut self, database: &str, version: i64) -> Result<Bytes, Died> {
        let path = format!("/v1/databases/{database}/versions/{version}/artifact");
        let answer = self.ask(Method::GET, &path, |request| request).await?;
        assert_eq!(answer.status, 200, "{:#}", answer.json());
        self.known.facts.insert(path, Fact::Bytes(answer.body.clone()));
        Ok(answer.body)
    }

    async fn import(&mut self, database: &str, artifact: Bytes) -> Result<(), Died> {
        let path = format!("/v1/databases/{database}/versions");
        let answer = self
            .ask(Method::POST, &path, |request| {
                request.header("content-type", "application/octet-stream").body(artifact.clone())
            })
            .await?;
        assert!(answer.is_well(), "{:#}", answer.json());
        let at = format!("{path}/{}", answer.json()["version"]);
        self.known.facts.insert(at, Fact::Has(json!({"digest": answer.json()["digest"]})));
        Ok(())
    }

    /// The same digest gives the same answer to the same picture, whichever process gives it.
    pub async fn recognise(&mut self, database: &str) -> Result<(), Died> {
        let path = format!("/v1/databases/{database}/recognitions");
        let answer = self.client.post_picture(&path, scene_png(ASKED)).await?;
        assert_eq!(answer.status, 200, "{:#}", answer.json());
        self.is_as_before(&answer.json());
        self.has_asked = true;
        Ok(())
    }

    fn is_as_before(&mut self, answer: &Value) {
        let said = json!([answer["decision"], answer["votes"], answer["confidence"]]);
        assert!(answer["votes"].as_array().is_some_and(|votes| !votes.is_empty()), "{answer:#}");
        let digest = answer["digest"].as_str().unwrap().to_owned();
        let before = self.known.answers.entry(digest).or_insert_with(|| said.clone());
        assert_eq!(*before, said, "the same version answers otherwise");
    }

    /// Hold everything that was acknowledged against what a process over the folder says now.
    pub async fn check(&mut self, folder: &Path, context: &str) {
        self.try_check(folder, context)
            .await
            .unwrap_or_else(|Died| panic!("died while it was looked at: {context}"));
    }

    async fn try_check(&mut self, folder: &Path, context: &str) -> Result<(), Died> {
        let ready = self.client.get("/readyz").await?.expect(200);
        assert_eq!(ready["status"], "ready", "{ready:#} {context}");
        let jobs = self.client.get("/v1/jobs?limit=1000").await?.expect(200);
        for job in jobs["items"].as_array().unwrap() {
            let job = self.client.ended(job["id"].as_str().unwrap()).await?;
            assert_eq!(job["state"], "succeeded", "{job:#} {context}");
        }
        let client = self.client.clone();
        let facts = self.known.facts.clone();
        futures_util::stream::iter(facts)
            .map(|(path, fact)| holds(client.clone(), path, fact, context))
            .buffer_unordered(4)
            .collect::<Vec<()>>()
            .await;
        for database in ["lab", "spare"] {
            self.answers_by_its_alias(database, context).await?;
        }
        verify(folder).unwrap_or_else(|said| panic!("{said} {context}"));
        Ok(())
    }

    /// `current` names a whole version, which answers as ever; and nothing was published twice.
    async fn answers_by_its_alias(&mut self, database: &str, context: &str) -> Result<(), Died> {
        let path = format!("/v1/databases/{database}");
        let named = self.client.get(&format!("{path}/aliases/current")).await?;
        if named.status == 404 {
            return Ok(());
        }
        let version = named.expect(200)["version"].clone();
        let versions = self.client.get(&format!("{path}/versions?limit=1000")).await?.expect(200);
        let versions = versions["items"].as_array().unwrap();
        let mut digests: Vec<_> = versions.iter().map(|row| row["digest"].as_str().unwrap()).collect();
        digests.sort_unstable();
        digests.dedup();
        assert_eq!(digests.len(), versions.len(), "published twice: {context}");
        let asked = self.client.post_picture(&format!("{path}/recognitions"), scene_png(ASKED)).await?;
        let answer = asked.expect(200);
        assert_eq!(answer["version"], version, "{context}");
        let row = versions.iter().find(|row| row["version"] == version);
        assert_eq!(row.map(|row| &row["digest"]), Some(&answer["digest"]), "{context}");
        self.is_as_before(&answer);
        Ok(())
    }
}

fn is_at_or_below(at: &str, path: &str) -> bool {
    at.strip_prefix(path).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

async fn holds(client: Client, path: String, fact: Fact, context: &str) {
    let answer = client.get(&path).await.unwrap_or_else(|Died| panic!("died at {path}: {context}"));
    let (status, body) = (answer.status, answer.json());
    match fact {
        Fact::Gone => assert_eq!(status, 404, "{path} is there again: {body:#} {context}"),
        Fact::Bytes(bytes) => assert!(
            status == 200 && answer.body == bytes,
            "{path}: {status}, {} bytes of {}: {context}",
            answer.body.len(),
            bytes.len()
        ),
        Fact::Has(members) => {
            assert_eq!(status, 200, "{path}: {body:#} {context}");
            for (name, value) in members.as_object().unwrap() {
                assert_eq!(&body[name], value, "{path}: {name} {context}");
            }
        }
    }
}
