//! `GET /v1/databases/{database}/versions/{version}/eigenimages/{image}`: what an object database sees with.

use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::IntoParams;

use super::Service;
use super::extract::Path;
use super::problem::{Code, Problem};
use super::versions::{IfNoneMatch, if_none_match};
use crate::compute::Lane;
use crate::database::{LoadedVersion, Model, Name};
use landmarkd_core::imaging::Image;
use landmarkd_core::imaging::encode::png_gray8;

/// The eigenimage that a call is about.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct EigenimagePath {
    /// Name of the database.
    #[param(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub database: Name,
    /// Number of the version.
    #[param(minimum = 1)]
    pub version: i64,
    /// `mean`, or the number of an eigenimage of the universal eigenspace, counted from 0.
    #[param(pattern = "^(mean|[0-9]+)$")]
    pub image: String,
}

/// Which picture of an eigenspace.
#[derive(Debug, Clone, Copy)]
enum Eigenimage {
    Mean,
    Direction(usize),
}

impl Eigenimage {
    fn of(word: &str) -> Result<Self, Problem> {
        match word {
            "mean" => Ok(Self::Mean),
            digits if !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit()) => {
                // A number too long to be read is beyond every dimension too.
                Ok(Self::Direction(digits.parse().unwrap_or(usize::MAX)))
            }
            other => Err(Problem::field(
                "#image",
                format!("{other:?} is neither mean nor a number counted from 0"),
            )),
        }
    }
}

/// The mean appearance of an object database, or an eigenimage of its universal eigenspace: zero is mid-gray.
#[utoipa::path(
    get, operation_id = "get_eigenimage",
    path = "/v1/databases/{database}/versions/{version}/eigenimages/{image}", tag = "databases", security(("key" = ["recognise"])),
    params(EigenimagePath),
    responses(
        (status = 200, description = "The picture", body = Vec<u8>, content_type = "image/png",
         headers(("ETag" = String))),
        (status = 304, description = "You have it"),
    )
)]
pub async fn get(
    State(service): State<Service>,
    Path(path): Path<EigenimagePath>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let which = Eigenimage::of(&path.image)?;
    service.databases.get(&path.database).await?;
    let version = service.databases.version_model(&path.database, path.version).await?;
    let etag = format!("{}-{}", version.digest, path.image);
    let draw = move || {
        let picture = picture(&version, which)?;
        Ok::<_, Problem>(png_gray8(picture.width(), picture.height(), &picture.to_gray8()))
    };
    let png = service.compute.run(Lane::Maintenance, 0, draw).await?.0?;
    let etag = match if_none_match(&headers, &etag)? {
        IfNoneMatch::NotModified(response) => return Ok(response),
        IfNoneMatch::Modified(etag) => etag,
    };
    let kind = HeaderValue::from_static("image/png");
    let cache = HeaderValue::from_static("private, no-cache");
    let headers = [(header::ETAG, etag), (header::CONTENT_TYPE, kind), (header::CACHE_CONTROL, cache)];
    Ok((headers, png).into_response())
}

fn picture(version: &LoadedVersion, which: Eigenimage) -> Result<Image, Problem> {
    let unknown = |text: String| Problem::new(Code::UnknownEigenimage, text);
    let Model::Objects(objects) = &version.model else {
        return Err(unknown(format!(
            "database {} is of kind landmarks: its signatures have no eigenimages, versions of kind objects do",
            version.database
        )));
    };
    match which {
        Eigenimage::Mean => Ok(objects.mean_picture()),
        Eigenimage::Direction(direction) => objects.eigenimage(direction).ok_or_else(|| {
            let (count, last) = (objects.dimension(), objects.dimension().saturating_sub(1));
            unknown(format!(
                "version {} has {count} eigenimages: ask for 0 to {last}, or for mean",
                version.version
            ))
        }),
    }
}
