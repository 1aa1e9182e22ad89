//! Five times what it can do: what it does then, and what it says to the rest.

use std::sync::Arc;
use std::time::{Duration, Instant};

use reqwest::Method;
use serde_json::json;
use tokio::sync::mpsc;
use tokio::task::JoinSet;

use crate::client::Client;
use crate::figures::{Times, cpu_seconds, load_lasts, memory_bytes};
use crate::service::{Service, livez, recognition, room};

/// Clients that wait for each answer: enough to keep both threads busy.
const PATIENT: usize = 8;
/// Clients that don't: more than the 130 whose requests may run or wait, and fewer than the 512 connections that one
/// address may have.
const IMPATIENT: usize = 400;
/// So many times what it can do.
const FACTOR: f64 = 5.0;
const MIB: f64 = (1 << 20) as f64;

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "measures time on a machine of its own; run by .ci/run"]
async fn five_times_too_much_leaves_goodput_near_its_peak_and_memory_bounded() {
    let service = Service::start(&[]);
    let address: Arc<str> = service.process.address().into();
    service.taught("hall", json!({}), &(1..=6).map(room).collect::<Vec<_>>()).await;
    service.train("hall", json!({})).await;
    let request: Arc<[u8]> = recognition("hall", &room(1)).into();
    let begins_with = memory_bytes(service.process.id(), "VmRSS");

    // A client that asks as soon as it is answered can't ask too much.
    let peak_lasts = load_lasts() / 3;
    let until = Instant::now() + peak_lasts;
    let mut patient = JoinSet::new();
    for _ in 0..PATIENT {
        let (address, request) = (Arc::clone(&address), Arc::clone(&request));
        patient.spawn(async move {
            let mut client = Client::connect(&address).await;
            let mut answers = Vec::new();
            while Instant::now() < until {
                answers.push(client.ask(&request).await);
            }
            answers
        });
    }
    let answers = patient.join_all().await.concat();
    assert!(answers.iter().all(|answer| answer.status == 200));
    let peak = answers.len() as f64 / peak_lasts.as_secs_f64();
    println!("peak: {peak:.1} recognitions a second by {PATIENT} clients; {}", Times::of(&answers));

    // Requests are sent when they are due, whatever became of those before.
    let every = Duration::from_secs_f64(1.0 / (FACTOR * peak));
    let (back, mut idle) = mpsc::unbounded_channel();
    for _ in 0..IMPATIENT {
        back.send(Client::connect(&address).await).unwrap();
    }
    let (begun, own_cpu) = (Instant::now(), cpu_seconds());
    let until = begun + load_lasts();
    let flood = tokio::spawn(async move {
        let (mut asking, mut due) = (JoinSet::new(), begun);
        while due < until {
            tokio::time::sleep_until(due.into()).await;
            let mut client: Client = idle.try_recv().expect("fewer wait than there are clients");
            let (back, request) = (back.clone(), Arc::clone(&request));
            asking.spawn(async move {
                let answer = client.ask(&request).await;
                // Nobody asks any more at the end.
                let _ = back.send(client);
                answer
            });
            due += every;
        }
        (asking.join_all().await, begun.elapsed().as_secs_f64())
    });
    let mut watcher = Client::connect(&address).await;
    let alive = watcher.ask_at(&livez(), 50.0, until).await;
    let (answers, took) = flood.await.unwrap();

    let own_cores = (cpu_seconds() - own_cpu) / begun.elapsed().as_secs_f64();
    let cores = std::thread::available_parallelism().unwrap().get() as f64;
    let left = peak * (cores - own_cores) / cores;
    let good: Vec<_> = answers.iter().filter(|answer| answer.status == 200).collect();
    let refused: Vec<_> = answers.iter().filter(|answer| matches!(answer.status, 429 | 503)).collect();
    let offered = answers.len() as f64 / load_lasts().as_secs_f64();
    let goodput = good.len() as f64 / took;
    println!(
        "offered {offered:.1} a second, {:.1} times the peak: {goodput:.1} answered a second for {took:.1} s, {:.0} % of \
         the peak",
        offered / peak,
        goodput / peak * 100.0
    );
    println!(
        "whoever asks takes {own_cores:.2} of {cores} cores: {:.0} % of what the others could do",
        goodput / left * 100.0
    );
    println!("answered: {}", Times::of(good.iter().copied()));
    println!("refused: {}", Times::of(refused.iter().copied()));
    println!("/livez: {}", Times::of(&alive));

    // What all limits allow together, over what the process took with its version loaded: bodies, pictures being worked
    // on, tracks, and connections of HTTP/1.1, each with two buffers of 16 KiB and as much again for its task.
    let limits = service.send(Method::GET, "/v1/info", None).await["limits"].take();
    let limit = |name: &str| limits[name].as_u64().unwrap();
    let bound = begins_with
        + limit("max_body_bytes_total")
        + limit("max_decode_bytes_total")
        + limit("max_tracks_bytes")
        + limit("max_connections") * (64 << 10);
    let most = memory_bytes(service.process.id(), "VmHWM");
    println!(
        "memory: {:.0} MiB with the version loaded, {:.0} MiB at most, bound {:.0} MiB",
        begins_with as f64 / MIB,
        most as f64 / MIB,
        bound as f64 / MIB
    );

    assert_eq!(good.len() + refused.len(), answers.len(), "nothing but answers and refusals");
    assert!(refused.iter().all(|answer| answer.says_when), "who is refused is told when to come back");
    assert!(alive.iter().all(|answer| answer.status == 200));
    assert!(most < bound);
    // What waits here are some hundred small frames: far from the bound, and no more than that.
    assert!(most < begins_with + (128 << 20), "{most} after {begins_with}");
    assert!(goodput > peak / 2.0, "{goodput} answered a second, and {peak} at the peak");
    assert!(
        Times::of(&alive).percentile(99) < Duration::from_secs(1),
        "what needs no computing doesn't wait"
    );
}
