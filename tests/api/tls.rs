//! TLS on the real binary: both versions of HTTP, certificates that change while it runs, and what is refused.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use rcgen::{CertifiedKey, generate_simple_self_signed};
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, RootCertStore};
use tokio_rustls::TlsConnector;

use crate::process::{Process, landmarkd};
use crate::waits::{until, until_blocking};

const PATIENCE: Duration = Duration::from_secs(20);

/// A new certificate and its key in the folder; the certificate.
fn write_pair(folder: &Path) -> CertificateDer<'static> {
    let CertifiedKey { cert, signing_key } = generate_simple_self_signed(["localhost".to_owned()]).unwrap();
    std::fs::write(folder.join("key.pem"), signing_key.serialize_pem()).unwrap();
    std::fs::write(folder.join("cert.pem"), cert.pem()).unwrap();
    cert.der().clone()
}

/// The service over TLS; what it stores is in the folder beside the pair.
fn start(folder: &Path) -> Process {
    Process::start_with(&folder.join("data"), |command| {
        command.arg("--tls-cert").arg(folder.join("cert.pem"));
        command.arg("--tls-key").arg(folder.join("key.pem"));
        command.args(["--header-timeout-s", "1"]);
    })
}

/// A client that trusts this certificate and no other, and speaks these protocols.
fn client(trusted: &CertificateDer<'static>, protocols: &[&[u8]]) -> Arc<ClientConfig> {
    let mut roots = RootCertStore::empty();
    roots.add(trusted.clone()).unwrap();
    let ring = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(ring).with_safe_default_protocol_versions().unwrap();
    let mut config = config.with_root_certificates(roots).with_no_client_auth();
    config.alpn_protocols = protocols.iter().map(|protocol| protocol.to_vec()).collect();
    Arc::new(config)
}

/// Ask for `/livez` by HTTP/1.1; an error if the certificate isn't the trusted one.
async fn alive(process: &Process, trusted: &CertificateDer<'static>) -> std::io::Result<()> {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let stream = tokio::net::TcpStream::connect(process.address()).await?;
    let connector = TlsConnector::from(client(trusted, &[b"http/1.1"]));
    let mut stream = connector.connect(ServerName::try_from("localhost").unwrap(), stream).await?;
    stream.write_all(b"GET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").await?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await?;
    assert!(answer.starts_with("HTTP/1.1 200 ") && answer.contains("alive"), "{answer}");
    Ok(())
}

async fn becomes_alive(process: &Process, trusted: &CertificateDer<'static>) {
    until("the certificate is served", async || alive(process, trusted).await.is_ok()).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn certificates_are_read_again_when_they_change_and_a_broken_one_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let first = write_pair(folder.path());
    let process = start(folder.path());
    alive(&process, &first).await.unwrap();
    let second = write_pair(folder.path());
    becomes_alive(&process, &second).await;
    assert!(alive(&process, &first).await.is_err());
    // A key of another pair; what stays in force is the pair before.
    std::fs::write(folder.path().join("key.pem"), "no key").unwrap();
    tokio::time::sleep(Duration::from_secs(3)).await;
    alive(&process, &second).await.unwrap();
    let (status, log) = tokio::task::spawn_blocking(|| process.terminate()).await.unwrap();
    assert!(status.success());
    assert!(log.iter().any(|line| line.contains("the one before it stays")), "{log:#?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn http2_is_spoken_with_bounded_streams_and_headers() {
    let folder = tempfile::tempdir().unwrap();
    let trusted = write_pair(folder.path());
    let process = start(folder.path());
    let stream = tokio::net::TcpStream::connect(process.address()).await.unwrap();
    let connector = TlsConnector::from(client(&trusted, &[b"h2", b"http/1.1"]));
    let stream = connector.connect(ServerName::try_from("localhost").unwrap(), stream).await.unwrap();
    assert_eq!(stream.get_ref().1.alpn_protocol(), Some(&b"h2"[..]));
    let (mut sender, connection) = h2::client::handshake(stream).await.unwrap();
    let connection = tokio::spawn(connection);
    let request = |path: &str| axum::http::Request::get(format!("https://localhost{path}")).body(()).unwrap();
    // Larger than a window, so that pieces and windows must go on working.
    let (answer, _) = sender.send_request(request("/openapi.json"), true).unwrap();
    let (head, mut body) = answer.await.unwrap().into_parts();
    let mut came = 0;
    while let Some(piece) = body.data().await {
        let piece = piece.unwrap();
        came += piece.len();
        body.flow_control().release_capacity(piece.len()).unwrap();
    }
    assert_eq!(head.status, 200);
    assert_eq!(head.headers["content-length"].to_str().unwrap(), came.to_string());
    assert_eq!(sender.current_max_send_streams(), 32);
    let mut long = request("/livez");
    long.headers_mut().insert("x-long", "x".repeat(17_000).parse().unwrap());
    let refused = sender.send_request(long, true).unwrap().0.await;
    assert!(refused.is_err() || refused.unwrap().status() == 431);
    // The connection goes on.
    let (answer, _) = sender.send_request(request("/livez"), true).unwrap();
    assert_eq!(answer.await.unwrap().status(), 200);
    drop(body);
    drop(sender);
    tokio::time::timeout(PATIENCE, connection).await.unwrap().unwrap().unwrap();
}

#[test]
fn who_does_not_shake_hands_is_cut_off() {
    let folder = tempfile::tempdir().unwrap();
    write_pair(folder.path());
    let process = start(folder.path());
    let mut silent = TcpStream::connect(process.address()).unwrap();
    let mut begun = TcpStream::connect(process.address()).unwrap();
    // The first bytes of a ClientHello that promises 512.
    begun.write_all(&[22, 3, 1, 2, 0, 1]).unwrap();
    for stream in [&mut silent, &mut begun] {
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        assert_eq!(stream.read(&mut [0; 16]).unwrap_or_default(), 0, "ended without a word");
    }
    // HTTP without TLS is answered by TLS's alert, or not at all.
    let mut plain = TcpStream::connect(process.address()).unwrap();
    plain.write_all(b"GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    plain.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut answer = Vec::new();
    let _ = plain.read_to_end(&mut answer);
    assert!(!answer.starts_with(b"HTTP"), "{answer:?}");
}

#[test]
fn the_health_check_asks_a_service_over_tls_where_it_is_told_of_the_certificate() {
    let folder = tempfile::tempdir().unwrap();
    write_pair(folder.path());
    let process = start(folder.path());
    let check = |with_certificate: bool| {
        let mut command = landmarkd();
        command.args(["healthcheck", "--bind", process.address()]);
        if with_certificate {
            command.env("LANDMARKD_TLS_CERT", folder.path().join("cert.pem"));
        }
        command.output().unwrap().status.success()
    };
    until_blocking("healthy", || check(true));
    assert!(!check(false));
}

#[test]
fn a_pair_that_is_none_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    write_pair(folder.path());
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("empty.pem"), "").unwrap();
    let other = tempfile::tempdir().unwrap();
    write_pair(other.path());
    for (cert, key, says) in [
        (path("cert.pem"), None, "--tls-cert and --tls-key belong together"),
        (path("none.pem"), Some(path("key.pem")), "can't read"),
        (path("empty.pem"), Some(path("key.pem")), "holds no certificate"),
        (path("cert.pem"), Some(path("cert.pem")), "holds no private key"),
        (path("cert.pem"), Some(other.path().join("key.pem")), "don't make a pair"),
    ] {
        let mut command = landmarkd();
        command.args(["serve", "--bind", "127.0.0.1:0", "--data-dir"]).arg(path("data"));
        command.arg("--tls-cert").arg(&cert);
        if let Some(key) = &key {
            command.arg("--tls-key").arg(key);
        }
        let output = command.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains(says), "{says:?}: {said}");
    }
}
