//! Options of a depth map.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::read_members;
use crate::database::DepthMethodWord;
use crate::database::words::AutoWord;
use crate::http::problem::FieldError;
use landmarkd_core::depth::{DepthOptions, Median, Window};

/// Done by itself, or not at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum AutoOrNoneWord {
    /// Found from the pictures.
    Auto,
    /// Not at all.
    None,
}

/// The standard deviation of a Gaussian window in pixels, or `auto`: as large as the texture needs, pixel by pixel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged, expecting = "expected a number of pixels or \"auto\"")]
pub enum WindowBody {
    // In pixels.
    Number(f64),
    // By the texture.
    Word(AutoWord),
}

/// Options of a depth map. What is absent has its default.
#[derive(Debug, Clone, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DepthOptionsBody {
    /// `gram` by default.
    #[schema(required = false)]
    pub method: Option<DepthMethodWord>,
    /// 1 to 32 px, or `auto`, the default.
    #[schema(required = false)]
    pub window: Option<WindowBody>,
    /// Whether a shift between the pictures is looked for and taken out; `auto` by default.
    #[schema(required = false)]
    pub align: Option<AutoOrNoneWord>,
    /// Whether the pictures' brightness is matched; `auto` by default.
    #[schema(required = false)]
    pub photometric: Option<AutoOrNoneWord>,
    /// Side of a median over the depths: 0 (none, the default), 3 or 5.
    #[schema(maximum = 5, default = 0)]
    pub median: Option<u8>,
}

impl From<Window> for WindowBody {
    fn from(window: Window) -> Self {
        match window {
            Window::Auto => Self::Word(AutoWord::Auto),
            Window::Px(px) => Self::Number(px),
        }
    }
}

impl DepthOptionsBody {
    /// Reads the options from the members of the object `/options`, and finds everything that is wrong with them.
    pub fn read(body: &Map<String, Value>) -> (DepthOptions, Vec<FieldError>) {
        let (body, mut faults) = read_members::<Self>("/options", body);
        let mut options = DepthOptions::default();
        if let Some(method) = body.method {
            options.method = method.into();
        }
        match body.window {
            Some(WindowBody::Number(px)) => options.window = Window::Px(px),
            Some(WindowBody::Word(AutoWord::Auto)) | None => {}
        }
        options.align = body.align != Some(AutoOrNoneWord::None);
        options.match_brightness = body.photometric != Some(AutoOrNoneWord::None);
        match body.median {
            None | Some(0) => {}
            Some(3) => options.median = Median::Three,
            Some(5) => options.median = Median::Five,
            Some(other) => faults.push(FieldError {
                pointer: "/options/median".into(),
                detail: format!("must be 0, 3 or 5, not {other}"),
            }),
        }
        faults.extend(
            options.faults().into_iter().map(|fault| FieldError {
                pointer: format!("/options/{}", fault.field),
                detail: fault.message,
            }),
        );
        (options, faults)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::depth::Method;
    use serde_json::json;

    fn read(body: Value) -> (DepthOptions, Vec<FieldError>) {
        DepthOptionsBody::read(body.as_object().unwrap())
    }

    #[test]
    fn every_fault_is_named_at_once() {
        let (_, faults) = read(json!({
            "method": "stereo", "window": 99, "align": true, "photometric": "off", "median": 4, "colour": "auto",
        }));
        let mut at: Vec<&str> = faults.iter().map(|fault| fault.pointer.as_str()).collect();
        at.sort_unstable();
        let wrong = ["align", "colour", "median", "method", "photometric", "window"];
        assert_eq!(at, wrong.map(|option| format!("/options/{option}")));
    }

    #[test]
    fn what_is_absent_is_the_default_and_words_mean_what_they_say() {
        assert_eq!(read(json!({})), (DepthOptions::default(), vec![]));
        let auto =
            json!({"method": "gram", "window": "auto", "align": "auto", "photometric": "auto", "median": 0});
        assert_eq!(read(auto), (DepthOptions::default(), vec![]));
        let other =
            json!({"method": "stm", "window": 4, "align": "none", "photometric": "none", "median": 5});
        let expected = DepthOptions {
            method: Method::Stm,
            window: Window::Px(4.0),
            align: false,
            match_brightness: false,
            median: Median::Five,
        };
        assert_eq!(read(other), (expected, vec![]));
    }
}
