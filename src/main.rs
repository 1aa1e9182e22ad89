//! The verbs of `landmarkd`. Wires the parts, decides nothing.

use std::fmt::Display;
use std::io::{IsTerminal, Write};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use clap::{Parser, Subcommand};
use landmarkd::config::{GivenSettings, Settings};
use landmarkd::demo::{self, DemoArgs};
use landmarkd::evaluate::EvaluateArgs;
use landmarkd::evaluate::depth::{EvaluateDepthArgs, evaluate_depth};
use landmarkd::{http, serve, telemetry};
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
    /// Train on a folder, recognise queries with known truth, and tell how often the answer was right
    Evaluate(EvaluateArgs),
    /// Measure depth from a near- and a far-focused picture, and tell how far it is from the truth
    EvaluateDepth(EvaluateDepthArgs),
    /// Print the OpenAPI document
    Openapi,
    /// Succeed if the service at the address is ready
    Healthcheck {
        /// Where the service listens
        #[arg(long, env = "LANDMARKD_BIND", default_value = "127.0.0.1:8080", value_name = "ADDRESS")]
        bind: SocketAddr,
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
            telemetry::start_logging(settings.log_format, false);
            runtime()?.block_on(serve::serve(
                &settings,
                |address| {
                    tracing::info!(%address, data_dir = %settings.data_dir.display(), "listening");
                },
                stop_signal(),
            ))?;
            Ok(())
        }
        Verb::Demo { args, settings } => demonstrate(&args, settings),
        Verb::Evaluate(args) => evaluate(&args),
        Verb::EvaluateDepth(args) => print(&evaluate_depth(&args)?, args.json),
        Verb::Openapi => {
            std::io::stdout().write_all(http::openapi::text().as_bytes())?;
            Ok(())
        }
        Verb::Healthcheck { bind } => runtime()?.block_on(healthcheck(bind)),
    }
}

fn demonstrate(args: &DemoArgs, mut given: GivenSettings) -> anyhow::Result<()> {
    given.data_dir.get_or_insert_with(|| PathBuf::from("landmarkd-demo"));
    // Where no address was asked for, a taken one is no reason to stop.
    if given.bind.is_none() && std::net::TcpListener::bind(("127.0.0.1", 8080)).is_err() {
        given.bind = Some(SocketAddr::from(([127, 0, 0, 1], 0)));
    }
    let settings = Settings::settle(given, None)?;
    telemetry::start_logging(settings.log_format, true);
    runtime()?.block_on(async {
        let (announce, mut listening) = tokio::sync::mpsc::unbounded_channel();
        let (finished, finish) = tokio::sync::oneshot::channel::<()>();
        let stop = async {
            // Without --exit the other end is never used, and the signal decides.
            tokio::select! {
                () = stop_signal() => {}
                Ok(()) = finish => {}
            }
        };
        let serving = serve::serve(&settings, |address| announce.send(address).unwrap_or(()), stop);
        let showing = async {
            let Some(address) = listening.recv().await else { return anyhow::Ok(()) };
            let pictures = settings.data_dir.join("pictures");
            let shown =
                demo::run(&format!("http://{address}"), args, &pictures, &mut std::io::stdout()).await;
            if args.exit || shown.is_err() {
                finished.send(()).unwrap_or(());
            } else {
                println!("\nServing on http://{address} until Ctrl-C.");
                std::future::pending::<()>().await;
            }
            shown?;
            Ok(())
        };
        tokio::pin!(serving);
        tokio::select! {
            served = &mut serving => Ok(served?),
            shown = showing => {
                serving.await?;
                shown
            }
        }
    })
}

fn evaluate(args: &EvaluateArgs) -> anyhow::Result<()> {
    // Hidden where nobody looks on, so that a log holds the result alone.
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
    tokio::runtime::Builder::new_multi_thread().enable_all().build().context("can't start the async runtime")
}

/// Resolves at Ctrl-C or SIGTERM.
async fn stop_signal() {
    let interrupt = tokio::signal::ctrl_c();
    #[cfg(unix)]
    {
        match tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate()) {
            Ok(mut terminate) => tokio::select! {
                _ = interrupt => {}
                _ = terminate.recv() => {}
            },
            Err(_) => drop(interrupt.await),
        }
    }
    #[cfg(not(unix))]
    drop(interrupt.await);
}

async fn healthcheck(bind: SocketAddr) -> anyhow::Result<()> {
    // A service bound to every address answers on loopback.
    let host = match bind.ip() {
        ip if ip.is_unspecified() && ip.is_ipv4() => [127, 0, 0, 1].into(),
        ip if ip.is_unspecified() => std::net::Ipv6Addr::LOCALHOST.into(),
        ip => ip,
    };
    let url = format!("http://{}/readyz", SocketAddr::new(host, bind.port()));
    let client =
        reqwest::Client::builder().timeout(Duration::from_secs(5)).no_proxy().tls_certs_only([]).build()?;
    let answer = client.get(&url).send().await.with_context(|| format!("no answer from {url}"))?;
    anyhow::ensure!(answer.status().is_success(), "{url} answers {}", answer.status());
    if std::io::stdout().is_terminal() {
        println!("ready");
    }
    Ok(())
}
