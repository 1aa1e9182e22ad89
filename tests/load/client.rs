//! A client that costs little: prepared requests over sockets that stay open, and no more read of an answer than needed.

use std::time::{Duration, Instant};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::sleep_until;

/// Longer than the service may take.
const PATIENCE: Duration = Duration::from_secs(90);

/// What came of a request.
#[derive(Clone)]
pub struct Answer {
    pub status: u16,
    pub says_when: bool,
    pub took: Duration,
}

/// One connection.
pub struct Client {
    stream: TcpStream,
    buffer: Vec<u8>,
}

/// A request as it goes over the wire.
pub fn request(method: &str, path: &str, media_type: &str, body: &[u8]) -> Vec<u8> {
    let length = body.len();
    let head = format!(
        "{method} {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: {media_type}\r\nContent-Length: {length}\r\n\r\n"
    );
    [head.as_bytes(), body].concat()
}

impl Client {
    pub async fn connect(address: &str) -> Self {
        let stream = TcpStream::connect(address).await.unwrap();
        stream.set_nodelay(true).unwrap();
        Self { stream, buffer: Vec::with_capacity(1 << 14) }
    }

    /// Send a prepared request and take its whole answer.
    pub async fn ask(&mut self, request: &[u8]) -> Answer {
        let asking = self.answer(request);
        tokio::time::timeout(PATIENCE, asking).await.expect("an answer").expect("an unbroken connection")
    }

    async fn answer(&mut self, request: &[u8]) -> std::io::Result<Answer> {
        let begun = Instant::now();
        self.stream.write_all(request).await?;
        self.buffer.clear();
        let (head_bytes, length) = loop {
            if self.stream.read_buf(&mut self.buffer).await? == 0 {
                return Err(std::io::ErrorKind::UnexpectedEof.into());
            }
            let end = self.buffer.windows(4).position(|bytes| bytes == b"\r\n\r\n");
            if let Some(end) = end {
                let head = String::from_utf8_lossy(&self.buffer[..end]);
                let length = header(&head, "content-length").expect("answers here have a length");
                break (end + 4, length.parse::<usize>().unwrap());
            }
        };
        while self.buffer.len() < head_bytes + length {
            if self.stream.read_buf(&mut self.buffer).await? == 0 {
                return Err(std::io::ErrorKind::UnexpectedEof.into());
            }
        }
        let head = String::from_utf8_lossy(&self.buffer[..head_bytes]);
        Ok(Answer {
            status: head[9..12].parse().unwrap(),
            says_when: header(&head, "retry-after").is_some_and(|seconds| seconds.parse::<u64>().is_ok()),
            took: begun.elapsed(),
        })
    }

    /// Ask so many times a second until then, whatever the answers take: one that is late is followed at once. Time is
    /// counted from when a request was due.
    pub async fn ask_at(&mut self, request: &[u8], a_second: f64, until: Instant) -> Vec<Answer> {
        let every = Duration::from_secs_f64(1.0 / a_second);
        let mut due = Instant::now();
        let mut answers = Vec::new();
        while due < until {
            sleep_until(due.into()).await;
            let mut answer = self.ask(request).await;
            answer.took = due.elapsed();
            answers.push(answer);
            due += every;
        }
        answers
    }
}

fn header<'a>(head: &'a str, name: &str) -> Option<&'a str> {
    let mut lines = head.split("\r\n");
    lines.find_map(|line| line.strip_prefix(name)?.strip_prefix(": "))
}
