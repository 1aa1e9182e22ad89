//! Clients that hold connections and give nothing for it, beside one that asks.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::watch;

use crate::client::Client;
use crate::figures::{Times, load_lasts};
use crate::service::{Service, livez, recognition, room};

const HALF_OPEN: usize = 500;
const SLOW: usize = 100;
/// Requests a second of the client that asks.
const STEADY: f64 = 10.0;
/// The default of the service.
const HEADER_TIMEOUT: Duration = Duration::from_secs(10);
/// A client that holds a connection gives up after this.
const HELD_MOST: Duration = Duration::from_secs(60);

/// Connect and hold the connection, with a byte a second or none, time after time until told to stop; how long each was held.
async fn hold(address: Arc<str>, sends: bool, stop: watch::Receiver<bool>) -> Vec<Duration> {
    let mut held = Vec::new();
    let header = b"GET /livez HTTP/1.1\r\nHost: localhost\r\nX-Long: ".iter().chain(std::iter::repeat(&b'x'));
    while !*stop.borrow() {
        let Ok(mut stream) = TcpStream::connect(&*address).await else { break };
        let connected = Instant::now();
        let (mut reading, mut writing) = stream.split();
        let ended = async { while matches!(reading.read(&mut [0; 256]).await, Ok(1..)) {} };
        let sending = async {
            for byte in header.clone() {
                if sends && writing.write_all(&[*byte]).await.is_err() {
                    break;
                }
                tokio::time::sleep(Duration::from_secs(1)).await;
            }
        };
        tokio::select! {
            () = ended => {}
            () = sending => {}
            () = tokio::time::sleep(HELD_MOST) => {}
        }
        held.push(connected.elapsed());
        drop(stream);
        // Who was refused comes again a little later.
        tokio::time::sleep(Duration::from_millis(500)).await;
    }
    held
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "measures time on a machine of its own; run by .ci/run"]
async fn rude_clients_are_cut_off_and_hurt_nobody() {
    let service = Service::start(&[]);
    let address: Arc<str> = service.process.address().into();
    service.taught("hall", serde_json::json!({}), &(1..=6).map(room).collect::<Vec<_>>()).await;
    service.train("hall", serde_json::json!({})).await;
    let request = recognition("hall", &room(1));
    let mut client = Client::connect(&address).await;
    let half = load_lasts() / 2;
    let before = client.ask_at(&request, STEADY, Instant::now() + half).await;
    println!("before: {}", Times::of(&before));

    let (stop, stopped) = watch::channel(false);
    let rude = (0..HALF_OPEN + SLOW).map(|n| hold(Arc::clone(&address), n >= HALF_OPEN, stopped.clone()));
    let rude: Vec<_> = rude.map(tokio::spawn).collect();
    let begun = Instant::now();
    let until = begun + half.max(HEADER_TIMEOUT + Duration::from_secs(2));
    let during = client.ask_at(&request, STEADY, until).await;
    println!(
        "during, with {HALF_OPEN} half-open connections and {SLOW} of a byte a second: {}",
        Times::of(&during)
    );
    stop.send_replace(true);
    let mut held = Vec::new();
    for rude in rude {
        held.extend(rude.await.unwrap());
    }
    let refused = held.iter().filter(|held| **held < Duration::from_secs(1)).count();
    let longest = held.iter().max().unwrap();
    println!("{} connections: {refused} refused at once, the longest held for {longest:.1?}", held.len());

    assert!(before.iter().chain(&during).all(|answer| answer.status == 200), "the one that asks is answered");
    assert!(held.len() - refused >= HALF_OPEN / 2, "connections were held");
    assert!(*longest < HEADER_TIMEOUT * 2, "the service ends every connection in time: {longest:?}");
    let (before, during) = (Times::of(&before).percentile(50), Times::of(&during).percentile(50));
    assert!(during < before * 3 + Duration::from_millis(50), "{before:?}, {during:?}");
    // And there is room again.
    assert_eq!(Client::connect(&address).await.ask(&livez()).await.status, 200);
}
