//! Connections over real sockets: who says nothing, too little, or takes nothing is cut off in time, and nobody else.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use landmarkd::compute::Lane;
use landmarkd::config::Limits;
use landmarkd::{connections, http};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::watch;

use crate::app::{App, Occupied};
use crate::pictures::scene_png;
use crate::waits::until;

const LIVEZ: &[u8] = b"GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n";
/// Longer than any time-out of these tests, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

/// Have the app listen on a port of its own; it ends with the sender.
async fn listen(app: &App, change: impl FnOnce(&mut Limits)) -> (SocketAddr, watch::Sender<bool>) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let (shut_down, shutdown) = watch::channel(false);
    let router = http::router(app.service.clone());
    let mut limits = Limits::default();
    change(&mut limits);
    tokio::spawn(async move { connections::serve(listener, None, router, &limits, shutdown).await });
    (address, shut_down)
}

/// Read until the other side ends the connection; how much came, and how long it took.
async fn end(stream: &mut TcpStream) -> (usize, Duration) {
    let (started, mut came) = (Instant::now(), 0);
    let mut buffer = vec![0; 1 << 16];
    let reading = async {
        // A reset is an end too.
        while let Ok(bytes @ 1..) = stream.read(&mut buffer).await {
            came += bytes;
        }
    };
    tokio::time::timeout(PATIENCE, reading).await.expect("the connection is ended");
    (came, started.elapsed())
}

/// Ask for `/livez` and read the answer, without ending the connection.
async fn is_served(stream: &mut TcpStream) -> bool {
    let mut answer = Vec::new();
    let asking = async {
        stream.write_all(LIVEZ).await?;
        while !answer.ends_with(b"{\"status\":\"alive\"}") {
            if stream.read_buf(&mut answer).await? == 0 {
                break;
            }
        }
        std::io::Result::Ok(())
    };
    let asked = tokio::time::timeout(PATIENCE, asking).await.expect("an answer or an end");
    asked.is_ok() && answer.starts_with(b"HTTP/1.1 200 ")
}

#[tokio::test(flavor = "multi_thread")]
async fn who_sends_no_whole_header_is_cut_off_in_time() {
    let app = App::start().await;
    let header_timeout = Duration::from_millis(400);
    let (address, _serving) = listen(&app, |limits| limits.header_timeout = header_timeout).await;
    let mut silent = TcpStream::connect(address).await.unwrap();
    let mut begun = TcpStream::connect(address).await.unwrap();
    begun.write_all(&LIVEZ[..10]).await.unwrap();
    // The second header of a connection has as long from its first byte, not from the answer before.
    let mut second = TcpStream::connect(address).await.unwrap();
    assert!(is_served(&mut second).await);
    tokio::time::sleep(header_timeout * 2).await;
    assert!(is_served(&mut second).await);
    second.write_all(&LIVEZ[..10]).await.unwrap();
    let mut slow = TcpStream::connect(address).await.unwrap();
    let dribbling = async {
        for byte in LIVEZ.iter().cycle() {
            if slow.write_all(&[*byte]).await.is_err() {
                break;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    let (silent, begun, second, dribbled) = tokio::join!(
        end(&mut silent),
        end(&mut begun),
        end(&mut second),
        tokio::time::timeout(PATIENCE, dribbling)
    );
    assert_eq!((silent.0, begun.0, second.0), (0, 0, 0));
    assert!(second.1 >= header_timeout / 2, "{second:?}");
    assert!(dribbled.is_ok(), "a byte now and then doesn't count as a header");
}

#[tokio::test(flavor = "multi_thread")]
async fn an_idle_connection_stays_as_long_as_it_may_and_no_longer() {
    let app = App::start().await;
    let idle_timeout = Duration::from_millis(1500);
    let (address, _serving) = listen(&app, |limits| {
        limits.idle_timeout = idle_timeout;
        limits.header_timeout = Duration::from_millis(300);
    })
    .await;
    let mut stream = TcpStream::connect(address).await.unwrap();
    assert!(is_served(&mut stream).await);
    tokio::time::sleep(Duration::from_millis(700)).await;
    assert!(is_served(&mut stream).await, "longer than a header, shorter than idle");
    let (came, took) = end(&mut stream).await;
    assert_eq!(came, 0);
    assert!(took >= idle_timeout - Duration::from_millis(100), "{took:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn who_does_not_take_answers_is_cut_off() {
    let app = App::start().await;
    let (address, _serving) = listen(&app, |limits| limits.write_timeout = Duration::from_millis(500)).await;
    let mut stream = TcpStream::connect(address).await.unwrap();
    let ask = b"GET /openapi.json HTTP/1.1\r\nHost: localhost\r\n\r\n";
    stream.write_all(ask).await.unwrap();
    let mut head = [0; 1 << 10];
    stream.read_exact(&mut head).await.unwrap();
    let head = String::from_utf8_lossy(&head);
    let length = head.split("content-length: ").nth(1).unwrap().split('\r').next().unwrap();
    let answer_bytes: usize = length.parse().unwrap();
    // More than the buffers of both sockets hold together.
    let asked = 64_000_000 / answer_bytes;
    stream.write_all(&ask.repeat(asked)).await.unwrap();
    tokio::time::sleep(Duration::from_secs(2)).await;
    let (came, _) = end(&mut stream).await;
    assert!(came < asked * answer_bytes / 2, "{came} bytes of {asked} answers came");
    // Who takes them as they come gets all of them, however many.
    let mut stream = TcpStream::connect(address).await.unwrap();
    stream.write_all(&ask.repeat(20)).await.unwrap();
    let (mut came, mut buffer) = (0, vec![0; 1 << 16]);
    while came < 20 * answer_bytes {
        let bytes = stream.read(&mut buffer).await.unwrap();
        assert!(bytes > 0, "{came} bytes came");
        came += bytes;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn one_connection_too_many_is_closed_and_no_address_has_all() {
    let app = App::start().await;
    let (address, _serving) = listen(&app, |limits| limits.max_connections = 5).await;
    let connect = async |from: &str| {
        let socket = TcpSocket::new_v4().unwrap();
        socket.bind(format!("{from}:0").parse().unwrap()).unwrap();
        socket.connect(address).await.unwrap()
    };
    let mut own = Vec::new();
    for _ in 0..3 {
        let mut stream = connect("127.0.0.1").await;
        assert!(is_served(&mut stream).await);
        own.push(stream);
    }
    assert!(!is_served(&mut connect("127.0.0.1").await).await, "three of five are more than are left");
    // The whole of 127/8 is this machine on Linux alone.
    #[cfg(target_os = "linux")]
    {
        let mut other = connect("127.0.0.2").await;
        assert!(is_served(&mut other).await, "another address has its share");
    }
    for stream in &mut own {
        assert!(is_served(stream).await, "those that were there go on");
    }
    own.pop();
    until("who leaves makes room", async || is_served(&mut connect("127.0.0.1").await).await).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn work_of_a_client_that_hung_up_is_dropped_before_it_runs() {
    let app = App::start_with(|settings| settings.threads = 1).await;
    app.trained("lab", 2).await;
    let (address, _serving) = listen(&app, |_| ()).await;
    let _occupied = Occupied::lane(&app, Lane::Recognition).await;
    let waits_for = async |count: usize| {
        let compute = &app.service.compute;
        until(&format!("{count} wait"), async || compute.waiting(Lane::Recognition) == count).await;
    };
    let picture = scene_png(1);
    let head = format!(
        "POST /v1/databases/lab/recognitions HTTP/1.1\r\nHost: localhost\r\nContent-Type: image/png\r\nContent-Length: {}\r\n\r\n",
        picture.len()
    );
    let mut stream = TcpStream::connect(address).await.unwrap();
    stream.write_all(&[head.as_bytes(), &picture].concat()).await.unwrap();
    waits_for(1).await;
    drop(stream);
    waits_for(0).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn at_shutdown_idle_connections_end_at_once_and_those_that_begin_a_request_soon() {
    let app = App::start().await;
    // Longer than a test waits for the end of a connection: the shutdown ends them.
    let (address, shut_down) = listen(&app, |limits| limits.header_timeout = 2 * PATIENCE).await;
    let mut idle = TcpStream::connect(address).await.unwrap();
    assert!(is_served(&mut idle).await);
    let mut silent = TcpStream::connect(address).await.unwrap();
    let mut begun = TcpStream::connect(address).await.unwrap();
    begun.write_all(&LIVEZ[..10]).await.unwrap();
    tokio::time::sleep(Duration::from_millis(50)).await;
    shut_down.send_replace(true);
    let ends = async { tokio::join!(end(&mut idle), end(&mut silent), end(&mut begun)) };
    // Between the 2 s that a connection without a request gets and the 20 s after which the shutdown ends all.
    let ended = tokio::time::timeout(Duration::from_secs(10), ends).await;
    let (idle, silent, begun) = ended.expect("the shutdown waits for none of them");
    assert_eq!((idle.0, silent.0, begun.0), (0, 0, 0));
    assert!(TcpStream::connect(address).await.is_err(), "the port is closed");
}
