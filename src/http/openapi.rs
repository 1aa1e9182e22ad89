//! The OpenAPI document: generated from the handlers, committed as `openapi/landmarkd.json`, compared in a test.

use utoipa::OpenApi;
use utoipa::openapi::path::Operation;
use utoipa::openapi::{ContentBuilder, Ref, ResponseBuilder};

use super::problem::ProblemBody;
use super::{access, routes};

#[derive(OpenApi)]
#[openapi(
    info(
        title = "landmarkd",
        description = "Robots ask where they are and what they see: places and objects by local appearance, \
                       objects and how they are turned by their whole appearance, how far away everything is by \
                       two focal settings, which parts are on a table and where to reach, with the evidence behind each answer. Coordinates are pixels, x right, y down, origin at the \
                       centre of the top-left pixel. Errors are RFC 9457 problem documents.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0")
    ),
    components(schemas(ProblemBody)),
    tags(
        (name = "service", description = "Is it alive, what can it do"),
        (name = "databases", description = "Exemplars, versions and aliases under a name"),
        (name = "recognition", description = "Ask a frame what it shows"),
        (name = "depth", description = "How far away everything is, from a near- and a far-focused picture"),
        (name = "workcell", description = "Find every part on a table, say what it is, and where to reach"),
        (name = "jobs", description = "Long work, watched and cancelled"),
        (name = "access", description = "Who may call, and who changed what"),
    )
)]
struct Preamble;

/// What stands in the document before the routes.
pub(super) fn preamble() -> utoipa::openapi::OpenApi {
    Preamble::openapi()
}

/// The document with how a key is sent, and the problem document as the answer for every status that an operation doesn't name.
pub(super) fn finished(mut document: utoipa::openapi::OpenApi) -> utoipa::openapi::OpenApi {
    access::describe(&mut document);
    let problem = ResponseBuilder::new()
        .description("A problem document: what went wrong and what to do")
        .content(
            "application/problem+json",
            ContentBuilder::new().schema(Some(Ref::from_schema_name("Problem"))).build(),
        )
        .build();
    for item in document.paths.paths.values_mut() {
        let operations: [&mut Option<Operation>; 5] =
            [&mut item.get, &mut item.put, &mut item.post, &mut item.delete, &mut item.patch];
        for operation in operations.into_iter().flatten() {
            operation.responses.responses.insert("default".into(), problem.clone().into());
        }
    }
    document
}

/// The whole document.
pub fn document() -> utoipa::openapi::OpenApi {
    finished(routes().into_openapi())
}

/// The whole document as it is committed: pretty JSON with a line's end.
pub fn text() -> String {
    let text = document().to_pretty_json();
    text.expect("the document is made of text and numbers") + "\n"
}
