//! The catalogue or the bucket goes away and comes back; nobody restarts anything.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use serde_json::json;

use crate::fleet::{Client, Fleet};
use crate::pictures::{png, scene};
use crate::postgres::Stop;

/// How long a part is away; long enough for every connection to notice.
const AWAY: Duration = Duration::from_secs(30);
/// Longer than writes take to heal once it is back, on a busy machine.
const HEALING_PATIENCE: Duration = Duration::from_secs(30);
/// Longer than a refusal takes: who writes meanwhile doesn't wait for the part that is away.
const REFUSAL_PATIENCE: Duration = Duration::from_secs(6);

/// Recognise without pause until told to stop; how often that went well, and the longest answer.
struct Load {
    done: Arc<AtomicBool>,
    answered: Arc<AtomicU64>,
    clients: Vec<tokio::task::JoinHandle<Duration>>,
}

impl Load {
    fn start(client: &Client) -> Self {
        let (done, answered) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
        let clients = (0..4).map(|number| {
            let (client, done, answered) = (client.clone(), done.clone(), answered.clone());
            tokio::spawn(async move {
                let mut longest = Duration::ZERO;
                while !done.load(Ordering::Relaxed) {
                    let begun = Instant::now();
                    let (status, body) = client.recognise("hall", number).await;
                    assert_eq!(status, 200, "{body}");
                    longest = longest.max(begun.elapsed());
                    answered.fetch_add(1, Ordering::Relaxed);
                }
                longest
            })
        });
        Self { clients: clients.collect(), done, answered }
    }

    async fn stop(self) -> (u64, Duration) {
        self.done.store(true, Ordering::Relaxed);
        let mut longest = Duration::ZERO;
        for client in self.clients {
            longest = longest.max(client.await.unwrap());
        }
        (self.answered.load(Ordering::Relaxed), longest)
    }
}

/// Post pictures while a part is away: each is refused with 503 and when to come again.
async fn refused_writes(client: &Client, until: Instant) -> (usize, Duration) {
    let (mut refused, mut longest) = (0, Duration::ZERO);
    while Instant::now() < until {
        let begun = Instant::now();
        let picture = png(&scene(900 + refused as u64));
        let answer = client.send_picture("/v1/databases/hall/exemplars?label=late", picture).await;
        assert_eq!(answer.status(), 503);
        assert!(answer.headers().contains_key("retry-after"));
        longest = longest.max(begun.elapsed());
        refused += 1;
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
    (refused, longest)
}

/// Post a picture until it is taken; how many seconds that took since the part came back.
async fn healed(client: &Client, begun: Instant) -> f64 {
    tokio::time::timeout(HEALING_PATIENCE, taken(client)).await.expect("writes heal");
    begun.elapsed().as_secs_f64()
}

async fn taken(client: &Client) {
    loop {
        let posted =
            client.post_picture("/v1/databases/hall/exemplars?label=healed", png(&scene(800))).await.0;
        if posted == 200 || posted == 201 {
            return;
        }
        assert_eq!(posted, 503);
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn recognition_goes_on_while_postgresql_is_away_and_writes_heal_after_it() {
    let fleet = Fleet::new();
    let member = fleet.process(&[]);
    member.client.teach("hall", 0..4).await;
    member.client.trained("hall").await;
    let (_, before) = member.client.get("/v1/databases/hall").await;
    let load = Load::start(&member.client);
    fleet.cluster.stop(Stop::Immediate);
    let (refused, longest_write) = refused_writes(&member.client, Instant::now() + AWAY).await;
    let (status, ready) = member.client.get("/readyz").await;
    assert_eq!(
        (status, &ready["status"], &ready["catalogue"]),
        (200, &json!("degraded"), &json!("unavailable"))
    );
    fleet.cluster.start();
    let heals = healed(&member.client, Instant::now()).await;
    let (answered, longest) = load.stop().await;
    println!(
        "PostgreSQL away for 30 s: {answered} recognitions, none failed, longest {:.0} ms; {refused} writes refused, \
         longest {:.1} s; healed after {heals:.2} s",
        longest.as_secs_f64() * 1e3,
        longest_write.as_secs_f64(),
    );
    assert!(longest_write < REFUSAL_PATIENCE, "{longest_write:?}");
    let (_, after) = member.client.get("/v1/databases/hall").await;
    assert_eq!(after["exemplars"].as_u64(), before["exemplars"].as_u64().map(|n| n + 1));
    assert_eq!(member.client.trained("hall").await, 2);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn recognition_goes_on_while_the_bucket_is_away_and_writes_heal_after_it() {
    let fleet = Fleet::new();
    let member = fleet.process(&[]);
    member.client.teach("hall", 0..4).await;
    member.client.trained("hall").await;
    let load = Load::start(&member.client);
    fleet.bucket.goes_away();
    let (refused, longest_write) = refused_writes(&member.client, Instant::now() + AWAY).await;
    let (status, ready) = member.client.get("/readyz").await;
    assert_eq!((status, &ready["status"], &ready["blobs"]), (200, &json!("degraded"), &json!("unavailable")));
    fleet.bucket.comes_back();
    let heals = healed(&member.client, Instant::now()).await;
    let (answered, longest) = load.stop().await;
    println!(
        "bucket away for 30 s: {answered} recognitions, none failed, longest {:.0} ms; {refused} writes refused, \
         longest {:.1} s; healed after {heals:.2} s",
        longest.as_secs_f64() * 1e3,
        longest_write.as_secs_f64(),
    );
    assert!(longest_write < REFUSAL_PATIENCE, "{longest_write:?}");
    assert_eq!(member.client.trained("hall").await, 2);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn of_versions_in_the_bucket_what_was_read_is_answered_while_it_is_away_and_the_rest_heals() {
    let fleet = Fleet::new();
    let teacher = fleet.process(&[]);
    let (status, body) = teacher.client.put("/v1/databases/hall", &json!({"kind": "landmarks"})).await;
    assert_eq!(status, 201, "{body}");
    for number in 0..4 {
        teacher.client.teach_scene("hall", number).await;
    }
    let version = teacher.client.trained("hall").await;
    let keeps = fleet.process(&["--role", "serve", "--resident", "cache"]);
    // neither memory nor disk for what it read
    let nothing = ["--exemplar-cache-mb", "0", "--cache-limit-mb", "0"];
    let forgets = fleet.process(&[["--role", "serve", "--resident", "cache"], nothing].concat());
    for member in [&keeps, &forgets] {
        member.client.serves("hall", version).await;
        for number in 0..4 {
            let (status, answer) = member.client.recognise("hall", number).await;
            assert_eq!((status, &answer["decision"]["label"]), (200, &json!(format!("place{number}"))));
        }
    }
    let transactions = fleet.transactions();
    let load = Load::start(&keeps.client);
    fleet.bucket.goes_away();
    let (mut refused, begun) = (0, Instant::now());
    while begun.elapsed() < AWAY / 3 {
        let picture = png(&scene(refused % 4));
        let answer = forgets.client.send_picture("/v1/databases/hall/recognitions", picture).await;
        assert_eq!(answer.status(), 503);
        assert!(answer.headers().contains_key("retry-after"));
        refused += 1;
    }
    fleet.bucket.comes_back();
    let back = Instant::now();
    while forgets.client.recognise("hall", 1).await.0 != 200 {
        assert!(back.elapsed() < HEALING_PATIENCE);
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    let healed = back.elapsed().as_secs_f64();
    let (answered, longest) = load.stop().await;
    println!(
        "bucket away for 10 s: {answered} recognitions with what was read, none failed, longest {:.0} ms; without, {refused} \
         refused; healed after {healed:.2} s; {:.0} transactions of PostgreSQL meanwhile",
        longest.as_secs_f64() * 1e3,
        fleet.transactions() - transactions,
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn a_process_started_while_postgresql_is_away_waits_for_it() {
    let fleet = Fleet::new();
    drop(fleet.process(&[]));
    fleet.cluster.stop(Stop::Immediate);
    let (member, waited) = std::thread::scope(|scope| {
        let fleet = &fleet;
        let waiting = scope.spawn(|| (fleet.process(&[]), Instant::now()));
        std::thread::sleep(Duration::from_secs(5));
        assert!(!waiting.is_finished(), "it started without a catalogue");
        let back = Instant::now();
        fleet.cluster.start();
        let (member, listening) = waiting.join().unwrap();
        (member, listening - back)
    });
    println!("started while PostgreSQL was away: listened {:.1} s after its return", waited.as_secs_f64());
    let (_, log) = member.process.terminate();
    assert!(log.iter().any(|line| line.contains("the shared catalogue is away: waiting for it")), "{log:?}");
}
