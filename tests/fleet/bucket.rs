//! A private S3-compatible bucket for tests.
//!
//! One `moto_server` (`pip install 'moto[server]'`; found on the PATH, or named by `LANDMARKD_TEST_MOTO`) serves the
//! test process and ends with it, however that ends. Each bucket is reached through a proxy of its own, which can
//! refuse connections (the bucket is away, and its data is not lost) or hang (it takes requests and says nothing).

use std::collections::HashMap;
use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

/// The server; its guard ends it when the pipe from this process closes.
struct Moto {
    address: SocketAddr,
    _guard: Child,
}

/// The shell waits for the end of its standard input, which comes also when this process is killed.
const GUARD: &str = r#""$0" -H 127.0.0.1 -p "$1" >/dev/null 2>&1 & cat >/dev/null; kill -KILL $!"#;

impl Moto {
    fn shared() -> &'static Self {
        static MOTO: OnceLock<Moto> = OnceLock::new();
        MOTO.get_or_init(Self::start)
    }

    fn start() -> Self {
        let program = std::env::var_os("LANDMARKD_TEST_MOTO").unwrap_or_else(|| "moto_server".into());
        let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let guard = Command::new("sh")
            .arg("-c")
            .arg(GUARD)
            .arg(&program)
            .arg(address.port().to_string())
            .stdin(Stdio::piped())
            .spawn()
            .unwrap();
        let begun = Instant::now();
        while TcpStream::connect(address).is_err() {
            assert!(
                begun.elapsed() < Duration::from_secs(60),
                "{program:?} doesn't start: is moto[server] installed?"
            );
            thread::sleep(Duration::from_millis(50));
        }
        Self { address, _guard: guard }
    }
}

/// An empty bucket.
pub struct Bucket {
    name: String,
    proxy: Arc<Proxy>,
}

impl Bucket {
    /// Makes a bucket that nobody else uses.
    pub fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let name = format!("fleet-{}", NUMBER.fetch_add(1, Ordering::Relaxed));
        let bucket = Self { name, proxy: Proxy::start(Moto::shared().address) };
        bucket.request("PUT", "", b"");
        bucket
    }

    /// `http://127.0.0.1:…`, for `AWS_ENDPOINT_URL`; keys may be any, the region `us-east-1`.
    pub fn endpoint(&self) -> String {
        format!("http://{}", self.proxy.address)
    }

    /// `s3://bucket/blobs`.
    pub fn location(&self) -> String {
        format!("s3://{}/blobs", self.name)
    }

    /// Writes below `s3://bucket/blobs/`, past the proxy.
    pub fn overwrite(&self, key: &str, content: &[u8]) {
        self.request("PUT", &format!("/blobs/{key}"), content);
    }

    /// Refuses connections and cuts those that are there, until `comes_back`.
    pub fn goes_away(&self) {
        self.proxy.close();
    }

    /// Takes connections and requests, and answers none, until `comes_back`.
    pub fn hangs(&self) {
        self.proxy.hangs.store(true, Ordering::SeqCst);
    }

    pub fn comes_back(&self) {
        self.proxy.hangs.store(false, Ordering::SeqCst);
        self.proxy.open();
    }

    /// Bytes that clients have sent to it.
    pub fn bytes_received(&self) -> u64 {
        self.proxy.sent_bytes.load(Ordering::SeqCst)
    }

    fn request(&self, method: &str, path: &str, content: &[u8]) {
        let mut stream = TcpStream::connect(Moto::shared().address).unwrap();
        // The server asks for a signature and doesn't look at it.
        let head = format!(
            "{method} /{}{path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: {}\r\n\
             Authorization: AWS4-HMAC-SHA256 Credential=test/20000101/us-east-1/s3/aws4_request, \
             SignedHeaders=host, Signature=0\r\n\r\n",
            self.name,
            content.len()
        );
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(content).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.lines().next().is_some_and(|line| line.contains(" 200 ")), "{answer}");
    }
}

impl Drop for Bucket {
    fn drop(&mut self) {
        self.goes_away();
    }
}

struct Proxy {
    address: SocketAddr,
    server: SocketAddr,
    is_open: AtomicBool,
    hangs: AtomicBool,
    sent_bytes: AtomicU64,
    /// Both ends of every connection that lives, by its number.
    streams: Mutex<HashMap<u64, [TcpStream; 2]>>,
    accepting: Mutex<Option<thread::JoinHandle<()>>>,
}

impl Proxy {
    fn start(server: SocketAddr) -> Arc<Self> {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let proxy = Arc::new(Self {
            address: listener.local_addr().unwrap(),
            server,
            is_open: AtomicBool::new(true),
            hangs: AtomicBool::new(false),
            sent_bytes: AtomicU64::new(0),
            streams: Mutex::default(),
            accepting: Mutex::default(),
        });
        proxy.accept_from(listener);
        proxy
    }

    fn open(self: &Arc<Self>) {
        if !self.is_open.swap(true, Ordering::SeqCst) {
            self.accept_from(TcpListener::bind(self.address).unwrap());
        }
    }

    /// Returns when no connection is left and none is taken any more.
    fn close(&self) {
        if self.is_open.swap(false, Ordering::SeqCst) {
            // Wakes the thread that accepts.
            TcpStream::connect(self.address).ok();
            self.accepting.lock().unwrap().take().unwrap().join().unwrap();
            for stream in self.streams.lock().unwrap().values().flatten() {
                stream.shutdown(Shutdown::Both).ok();
            }
        }
    }

    fn accept_from(self: &Arc<Self>, listener: TcpListener) {
        let proxy = Arc::clone(self);
        let accepting = thread::spawn(move || {
            for number in 0.. {
                let Ok((client, _)) = listener.accept() else { return };
                if !proxy.is_open.load(Ordering::SeqCst) {
                    return;
                }
                let Ok(server) = TcpStream::connect(proxy.server) else { continue };
                let ends = [&client, &server].map(|stream| stream.try_clone().unwrap());
                proxy.streams.lock().unwrap().insert(number, ends);
                proxy.relay(client.try_clone().unwrap(), server.try_clone().unwrap(), Some(number));
                proxy.relay(server, client, None);
            }
        });
        *self.accepting.lock().unwrap() = Some(accepting);
    }

    /// Pass on what comes; the requests of a connection by its number, which then ends with them.
    fn relay(self: &Arc<Self>, mut from: TcpStream, mut to: TcpStream, requests: Option<u64>) {
        let proxy = Arc::clone(self);
        thread::spawn(move || {
            let mut buffer = vec![0; 64 << 10];
            while let Ok(count @ 1..) = from.read(&mut buffer) {
                while proxy.hangs.load(Ordering::SeqCst) && proxy.is_open.load(Ordering::SeqCst) {
                    thread::sleep(Duration::from_millis(5));
                }
                if requests.is_some() {
                    proxy.sent_bytes.fetch_add(count as u64, Ordering::SeqCst);
                }
                if to.write_all(&buffer[..count]).is_err() {
                    break;
                }
            }
            from.shutdown(Shutdown::Both).ok();
            to.shutdown(Shutdown::Both).ok();
            if let Some(number) = requests {
                proxy.streams.lock().unwrap().remove(&number);
            }
        });
    }
}
