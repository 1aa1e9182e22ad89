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

/// Time between two reads of the files.
const READ_EVERY: Duration = Duration::from_secs(2);

/// Why a certificate can't be used.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    /// A file isn't there, or may not be read.
    #[error("can't read {path}: check --tls-cert and --tls-key, and who may read the file")]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The certificate's file is something else.
    #[error("{path} holds no certificate as PEM")]
    NoCertificate {
        /// The file.
        path: PathBuf,
        /// What is wrong with it; none when it holds no certificate at all.
        source: Option<pem::Error>,
    },
    /// The key's file is something else.
    #[error("{path} holds no private key as PEM")]
    NoKey {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: pem::Error,
    },
    /// The key isn't that of the certificate.
    #[error("{} and {} don't make a pair", files.cert.display(), files.key.display())]
    NoPair {
        /// Both files.
        files: TlsFiles,
        /// What is wrong with them.
        source: rustls::Error,
    },
}

/// The TLS settings for new connections, as they change.
pub type ConfigReceiver = watch::Receiver<Arc<ServerConfig>>;

/// The bytes of both files.
#[derive(PartialEq, Eq)]
struct PemPair {
    cert: Vec<u8>,
    key: Vec<u8>,
}

impl PemPair {
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

    fn config(&self, files: &TlsFiles) -> Result<Arc<ServerConfig>, TlsError> {
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

/// The TLS settings for new connections, and a task that reads both files again for as long as it is polled. A pair that
/// can't be used leaves the one before it in force.
///
/// # Errors
/// [`TlsError`]: why the pair can't be used now.
pub async fn follow(files: TlsFiles) -> Result<(ConfigReceiver, impl Future<Output = ()> + Send), TlsError> {
    let mut current = PemPair::read(&files).await?;
    let (announce, in_force) = watch::channel(current.config(&files)?);
    let following = async move {
        let mut unreadable = false;
        loop {
            tokio::time::sleep(READ_EVERY).await;
            let config = match PemPair::read(&files).await {
                Ok(pair) if pair == current && !unreadable => continue,
                Ok(pair) => {
                    unreadable = false;
                    current = pair;
                    current.config(&files)
                }
                // Logged once, not at every read.
                Err(_) if unreadable => continue,
                Err(error) => {
                    unreadable = true;
                    Err(error)
                }
            };
            match config {
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
