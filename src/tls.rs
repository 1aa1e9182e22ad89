//! The service's certificate: read, offered for HTTP/2 and HTTP/1.1, and read again when its files change.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use rustls::ServerConfig;
use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, pem};
use tokio::sync::watch;

use crate::config::TlsFiles;
use crate::telemetry::chain;

/// How often the files are looked at.
const LOOK_EVERY: Duration = Duration::from_secs(2);

/// Why a certificate can't be used.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    #[error("can't read {path}: check --tls-cert and --tls-key, and who may read the file")]
    Unreadable { path: PathBuf, source: std::io::Error },
    #[error("{path} holds no certificate as PEM")]
    NoCertificate { path: PathBuf, source: Option<pem::Error> },
    #[error("{path} holds no private key as PEM")]
    NoKey { path: PathBuf, source: pem::Error },
    #[error("{} and {} don't make a pair", files.cert.display(), files.key.display())]
    NoPair { files: TlsFiles, source: rustls::Error },
}

/// What the two files hold.
#[derive(PartialEq, Eq)]
struct Texts {
    cert: Vec<u8>,
    key: Vec<u8>,
}

impl Texts {
    async fn read(files: &TlsFiles) -> Result<Self, TlsError> {
        let read = async |path: &PathBuf| {
            let unreadable = |source| TlsError::Unreadable { path: path.clone(), source };
            let reading = tokio::task::spawn_blocking({
                let path = path.clone();
                move || std::fs::read(path)
            });
            reading.await.map_err(|error| unreadable(error.into()))?.map_err(unreadable)
        };
        Ok(Self { cert: read(&files.cert).await?, key: read(&files.key).await? })
    }

    fn settle(&self, files: &TlsFiles) -> Result<Arc<ServerConfig>, TlsError> {
        let no_certificate = |source| TlsError::NoCertificate { path: files.cert.clone(), source };
        let chain: Vec<_> = CertificateDer::pem_slice_iter(&self.cert)
            .collect::<Result<_, _>>()
            .map_err(|source| no_certificate(Some(source)))?;
        if chain.is_empty() {
            return Err(no_certificate(None));
        }
        let key = PrivateKeyDer::from_pem_slice(&self.key)
            .map_err(|source| TlsError::NoKey { path: files.key.clone(), source })?;
        let no_pair = |source| TlsError::NoPair { files: files.clone(), source };
        let mut config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()
            .map_err(no_pair)?
            .with_no_client_auth()
            .with_single_cert(chain, key)
            .map_err(no_pair)?;
        config.alpn_protocols = vec![b"h2".to_vec(), b"http/1.1".to_vec()];
        Ok(Arc::new(config))
    }
}

/// The certificate in force for new connections, and a task that follows its files for as long as it is polled.
/// A pair that can't be used leaves the one before it in force.
///
/// # Errors
/// [`TlsError`]: why the pair can't be used now.
pub async fn follow(
    files: TlsFiles,
) -> Result<(watch::Receiver<Arc<ServerConfig>>, impl Future<Output = ()> + Send), TlsError> {
    let mut seen = Texts::read(&files).await?;
    let (announce, in_force) = watch::channel(seen.settle(&files)?);
    let following = async move {
        let mut unreadable = false;
        loop {
            tokio::time::sleep(LOOK_EVERY).await;
            let settled = match Texts::read(&files).await {
                Ok(texts) if texts == seen && !unreadable => continue,
                Ok(texts) => {
                    unreadable = false;
                    seen = texts;
                    seen.settle(&files)
                }
                // Told once, not at every look.
                Err(_) if unreadable => continue,
                Err(error) => {
                    unreadable = true;
                    Err(error)
                }
            };
            match settled {
                Ok(config) => {
                    announce.send_replace(config);
                    tracing::info!("new connections get the certificate as it is now");
                }
                Err(error) => tracing::warn!(
                    error = chain(&error),
                    "the new certificate can't be used; the one before it stays"
                ),
            }
        }
    };
    Ok((in_force, following))
}
