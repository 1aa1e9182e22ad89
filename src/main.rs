//! The verbs of `landmarkd`. Wires the parts, decides nothing.

use std::fmt::Display;
use std::io::{IsTerminal, Write};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use clap::{Parser, Subcommand};
use landmarkd::bag::{self, AskArgs, BagEvaluationArgs, ServiceArgs, TeachArgs};
use landmarkd::client::Server;
use landmarkd::config::{GivenSettings, Settings};
use landmarkd::demo::{self, DemoArgs};
use landmarkd::evaluate::EvaluateArgs;
use landmarkd::evaluate::depth::{EvaluateDepthArgs, evaluate_depth};
use landmarkd::keys::{self, KeysArgs};
use landmarkd::telemetry::Metrics;
use landmarkd::telemetry::otlp::Otlp;
use landmarkd::{database, http, serve, store, telemetry};
use serde::Serialize;

/// Robots ask where they are and what they see; the answer comes with its evidence.
#[derive(Parser)]
#[command(version, about, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Serve the databases of a folder over HTTP
    Serve {
        /// Settings as TOML; flags and environment win over it
        #[arg(long, env = "LANDMARKD_CONFIG", value_name = "FILE")]
        config: Option<PathBuf>,
        #[command(flatten)]
        settings: GivenSettings,
    },
    /// Learn pictures, ask about disturbed views of them over HTTP, tell how it went, and keep serving
    Demo {
        #[command(flatten)]
        args: DemoArgs,
        #[command(flatten)]
        settings: GivenSettings,
    },
    /// Teach a service the pictures of bags that a robot recorded, with their poses, and train
    Teach {
        #[command(flatten)]
        args: TeachArgs,
        #[command(flatten)]
        service: ServiceArgs,
    },
    /// Ask a service about the pictures of a bag, tell how well the answers agree with its poses, and write them as a bag
    Ask {
        #[command(flatten)]
        args: AskArgs,
        #[command(flatten)]
        service: ServiceArgs,
    },
    /// Train on a folder or a bag, recognise queries with known truth, and tell how often the answer was right
    Evaluate {
        #[command(flatten)]
        args: EvaluateArgs,
        #[command(flatten)]
        bags: BagEvaluationArgs,
    },
    /// Measure depth from a near- and a far-focused picture, and tell how far it is from the truth
    EvaluateDepth(EvaluateDepthArgs),
    /// Make, list and revoke the keys of a service
    Keys(KeysArgs),
    /// Copy a data folder, also while the service runs on it; to restore, serve on the copy
    Backup {
        /// Folder to copy
        #[arg(long, env = "LANDMARKD_DATA_DIR", default_value = "./landmarkd-data", value_name = "FOLDER")]
        data_dir: PathBuf,
        /// New folder for the copy
        #[arg(long, value_name = "FOLDER")]
        to: PathBuf,
    },
    /// Read everything in a data folder or a backup, and tell what is damaged
    Verify {
        /// Folder to read
        #[arg(long, env = "LANDMARKD_DATA_DIR", default_value = "./landmarkd-data", value_name = "FOLDER")]
        data_dir: PathBuf,
    },
    /// Print the OpenAPI document
    Openapi,
    /// Succeed if the service at the address is ready
    Healthcheck {
        /// Where the service listens
        #[arg(long, env = "LANDMARKD_BIND", default_value = "127.0.0.1:8080", value_name = "ADDRESS")]
        bind: SocketAddr,
        /// The certificate that the service serves with, if it does. It isn't held against the answer: nothing is told
        /// to the service, and names in certificates are rarely those of loopback
        #[arg(long, env = "LANDMARKD_TLS_CERT", value_name = "FILE")]
        tls_cert: Option<PathBuf>,
    },
}

fn main() -> ExitCode {
    // The one crypto provider of the process, before anything makes a client.
    rustls::crypto::ring::default_provider().install_default().ok();
    match run(Cli::parse().verb) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("landmarkd: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(verb: Verb) -> anyhow::Result<()> {
    match verb {
        Verb::Serve { config, settings } => {
            let settings = Settings::settle(settings, config.as_deref())?;
            let runtime = runtime()?;
            let entered = runtime.enter();
            // Dropped after the service has ended and before its runtime: what is pending is sent then.
            let mut otlp = settings.otlp_endpoint.as_deref().map(Otlp::start).transpose()?;
            drop(entered);
            telemetry::start_logging(settings.log_format, false, otlp.as_ref());
            let listening = |address: SocketAddr, metrics: &Metrics| {
                tracing::info!(%address, data_dir = %settings.data_dir.display(), "listening");
                let exported = otlp.as_mut().map_or(Ok(()), |otlp| metrics.export(otlp));
                if let Err(error) = exported {
                    tracing::error!(error = telemetry::chain(&error), "metrics are not exported");
                }
            };
            runtime.block_on(async {
                tokio::select! {
                    served = serve::serve(&settings, listening, stop_signals(1)) => Ok(served?),
                    () = stop_signals(2) => anyhow::bail!("ended at once, by a second signal"),
                }
            })
        }
        Verb::Demo { args, settings } => demonstrate(&args, settings),
        Verb::Teach { args, service } => runtime()?.block_on(async {
            bag::teach(&service.connect()?, &args, &mut std::io::stdout()).await?;
            Ok(())
        }),
        Verb::Ask { args, service } => runtime()?.block_on(async {
            let summary = bag::ask(&service.connect()?, &args, &mut std::io::stdout()).await?;
            write!(std::io::stdout(), "{summary}")?;
            Ok(())
        }),
        Verb::Evaluate { args, bags } => match bags.teach_and_ask(&args) {
            Some((teach, ask)) => evaluate_bags(&teach, &ask, args.json),
            None => evaluate(&args),
        },
        Verb::EvaluateDepth(args) => print(&evaluate_depth(&args)?, args.json),
        Verb::Keys(args) => {
            write!(std::io::stdout(), "{}", runtime()?.block_on(keys::run(args))?)?;
            Ok(())
        }
        Verb::Backup { data_dir, to } => runtime()?.block_on(back_up(&data_dir, &to)),
        Verb::Verify { data_dir } => runtime()?.block_on(verify(&data_dir)),
        Verb::Openapi => {
            std::io::stdout().write_all(http::openapi::text().as_bytes())?;
            Ok(())
        }
        Verb::Healthcheck { bind, tls_cert } => runtime()?.block_on(healthcheck(bind, tls_cert.is_some())),
    }
}

fn demonstrate(args: &DemoArgs, mut given: GivenSettings) -> anyhow::Result<()> {
    given.data_dir.get_or_insert_with(|| PathBuf::from("landmarkd-demo"));
    // Where no address was asked for, a taken one is no reason to stop.
    if given.bind.is_none() && std::net::TcpListener::bind(("127.0.0.1", 8080)).is_err() {
        given.bind = Some(SocketAddr::from(([127, 0, 0, 1], 0)));
    }
    let settings = Settings::settle(given, None)?;
    anyhow::ensure!(
        settings.tls.is_none(),
        "the demo is a client without TLS: leave out --tls-cert and --tls-key"
    );
    telemetry::start_logging(settings.log_format, true, None);
    runtime()?.block_on(serve_demo(args, &settings))
}

/// Serves, shows the demo to the service as its client, and goes on serving unless `--exit` is given.
async fn serve_demo(args: &DemoArgs, settings: &Settings) -> anyhow::Result<()> {
    let shown = beside_service(settings, async |base_url: String| {
        let pictures = settings.data_dir.join("pictures");
        demo::run(&base_url, args, &pictures, &mut std::io::stdout()).await?;
        if !args.exit {
            println!("\nServing on {base_url} until Ctrl-C.");
            std::future::pending::<()>().await;
        }
        Ok(())
    });
    shown.await.map(drop)
}

/// Serves as long as a client of the service is at work; `None` if a signal came first.
async fn beside_service<T>(
    settings: &Settings,
    client: impl AsyncFnOnce(String) -> anyhow::Result<T>,
) -> anyhow::Result<Option<T>> {
    let (announce, mut listening) = tokio::sync::mpsc::unbounded_channel();
    let (finished, finish) = tokio::sync::oneshot::channel::<()>();
    let stop = async {
        tokio::select! {
            () = stop_signals(1) => {}
            Ok(()) = finish => {}
        }
    };
    let serving = serve::serve(settings, |address, _| announce.send(address).unwrap_or(()), stop);
    let working = async {
        let Some(address) = listening.recv().await else { return Ok(None) };
        let done = client(format!("http://{address}")).await;
        finished.send(()).unwrap_or(());
        done.map(Some)
    };
    tokio::pin!(serving);
    tokio::select! {
        served = &mut serving => {
            served?;
            Ok(None)
        }
        done = working => {
            serving.await?;
            done
        }
    }
}

/// Teaches a service of its own one bag, and asks it about another.
fn evaluate_bags(teach: &TeachArgs, ask: &AskArgs, json: bool) -> anyhow::Result<()> {
    let data_dir = std::env::temp_dir().join(format!("landmarkd-evaluate-{}", std::process::id()));
    let given = GivenSettings {
        bind: Some(SocketAddr::from(([127, 0, 0, 1], 0))),
        data_dir: Some(data_dir.clone()),
        ..GivenSettings::default()
    };
    let settings = Settings::settle(given, None)?;
    telemetry::start_logging(settings.log_format, true, None);
    let evaluated = runtime()?.block_on(beside_service(&settings, async |base_url: String| {
        let server = Server::at(&base_url, None, None)?;
        let mut told = std::io::stderr();
        bag::teach(&server, teach, &mut told).await?;
        Ok(bag::ask(&server, ask, &mut told).await?)
    }));
    std::fs::remove_dir_all(&data_dir).ok();
    match evaluated? {
        Some(figures) => print(&figures, json),
        None => anyhow::bail!("ended by a signal"),
    }
}

fn evaluate(args: &EvaluateArgs) -> anyhow::Result<()> {
    // Hidden without a terminal, so that a log holds the result alone.
    let bar = indicatif::ProgressBar::new(0);
    let evaluation = landmarkd::evaluate::evaluate(&args.request()?, &mut |done, total| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    })?;
    bar.finish_and_clear();
    print(&evaluation, args.json)
}

/// Figures as a table, or as one JSON object.
fn print(figures: &(impl Display + Serialize), json: bool) -> anyhow::Result<()> {
    let mut out = std::io::stdout();
    if json {
        serde_json::to_writer(&mut out, figures)?;
        writeln!(out)?;
    } else {
        write!(out, "{figures}")?;
    }
    Ok(())
}

fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    // A training's futures are deep: builds that share less code between them need more than the default of 2 MiB.
    let mut runtime = tokio::runtime::Builder::new_multi_thread();
    runtime.enable_all().thread_stack_size(4 << 20).build().context("can't start the async runtime")
}

/// Resolves at so many Ctrl-Cs or SIGTERMs.
async fn stop_signals(count: usize) {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let (Ok(mut interrupt), Ok(mut terminate)) =
            (signal(SignalKind::interrupt()), signal(SignalKind::terminate()))
        {
            for _ in 0..count {
                tokio::select! {
                    _ = interrupt.recv() => {}
                    _ = terminate.recv() => {}
                }
            }
            return;
        }
    }
    for _ in 0..count {
        drop(tokio::signal::ctrl_c().await);
    }
}

async fn back_up(data_dir: &Path, to: &Path) -> anyhow::Result<()> {
    let backup = store::back_up(data_dir, to).await?;
    println!(
        "{} blobs of {} bytes in all, with their catalogue: {}",
        backup.blobs,
        backup.bytes,
        to.display()
    );
    for damaged in &backup.damaged {
        println!("not copied: {damaged}");
    }
    anyhow::ensure!(
        backup.damaged.is_empty(),
        "{} blobs are damaged or gone in {}, the rest is copied: landmarkd verify tells what they belong to",
        backup.damaged.len(),
        data_dir.display()
    );
    Ok(())
}

async fn verify(data_dir: &Path) -> anyhow::Result<()> {
    let folder = store::open_unlocked_folder(data_dir).await?;
    let mut faults = store::catalogue_faults(data_dir).await?;
    let verified = database::verify(&folder.catalogue, &folder.blobs).await?;
    faults.extend(verified.faults);
    for fault in &faults {
        println!("{fault}");
    }
    anyhow::ensure!(faults.is_empty(), "{} faults in {}", faults.len(), data_dir.display());
    println!("{} exemplars and {} versions are whole", verified.exemplars, verified.versions);
    Ok(())
}

async fn healthcheck(bind: SocketAddr, over_tls: bool) -> anyhow::Result<()> {
    // A service bound to every address answers on loopback.
    let host = match bind.ip() {
        ip if ip.is_unspecified() && ip.is_ipv4() => [127, 0, 0, 1].into(),
        ip if ip.is_unspecified() => std::net::Ipv6Addr::LOCALHOST.into(),
        ip => ip,
    };
    let scheme = if over_tls { "https" } else { "http" };
    let url = format!("{scheme}://{}/readyz", SocketAddr::new(host, bind.port()));
    let client = reqwest::Client::builder()
        .timeout(Duration::from_secs(5))
        .no_proxy()
        .tls_certs_only([])
        .tls_danger_accept_invalid_certs(over_tls)
        .build()?;
    let answer = client.get(&url).send().await.with_context(|| format!("no answer from {url}"))?;
    anyhow::ensure!(answer.status().is_success(), "{url} answers {}", answer.status());
    if std::io::stdout().is_terminal() {
        println!("ready");
    }
    Ok(())
}
