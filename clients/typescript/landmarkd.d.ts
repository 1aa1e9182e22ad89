// Made by "npm run generate" from the service's OpenAPI document.

export interface paths {
    "/livez": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** 200 while the process runs. */
        get: operations["livez"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/metrics": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Metrics in Prometheus' text format. */
        get: operations["metrics"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/readyz": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Whether the service answers recognitions; 503 only while starting or shutting down. */
        get: operations["readyz"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/audit": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Who changed what, the newest first: databases, aliases, versions, keys, calibrations, workcells, jobs and everything
         *     that was deleted. An entry is written with its change, and can't be changed or deleted.
         */
        get: operations["list_audit"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/calibrations": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Calibrations by name. */
        get: operations["list_calibrations"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/calibrations/{name}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One calibration. */
        get: operations["get_calibration"];
        /**
         * Describe a rig by its optics. The same optics again changes nothing; another drops what was measured with the one
         *     before: registration, brightness and table.
         */
        put: operations["put_calibration"];
        post?: never;
        /** Delete a calibration; its unfinished sweeps are cancelled. */
        delete: operations["delete_calibration"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/calibrations/{name}/registration": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Register the rig's two pictures by one textured target, and match their brightness. A table measured before is
         *     dropped: it was measured with another registration.
         */
        post: operations["register_calibration"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/calibrations/{name}/sweep": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Measure the rig's table: textured planes that face the camera, at known depths. Answers at once with a job. Planes
         *     that are too few, or don't reach past both focus distances, are refused at once; a sweep that isn't monotone fails
         *     the job.
         */
        post: operations["sweep_calibration"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Databases by name. */
        get: operations["list_databases"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One database with counts, aliases and current version. */
        get: operations["get_database"];
        /** Create a database, or change the options of the one of that name. */
        put: operations["put_database"];
        post?: never;
        /** Delete a database with all it holds. */
        delete: operations["delete_database"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/aliases": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The aliases of a database, by name. */
        get: operations["list_aliases"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/aliases/{alias}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One alias. */
        get: operations["get_alias"];
        /** Point an alias to a version. The answer comes when this process serves it. */
        put: operations["put_alias"];
        post?: never;
        /** Delete an alias; its version stays. */
        delete: operations["delete_alias"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/exemplars": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Training images by id. */
        get: operations["list_exemplars"];
        put?: never;
        /** Add a training image: the raw picture, or a form with a part `image`. The same again is the same exemplar. */
        post: operations["add_exemplar"];
        /**
         * Delete the training images that match all that is given: a label, a robot, a span of time; with nothing given, none
         *     and 400. Versions trained with them stay as they are: train anew, then delete the older versions.
         */
        delete: operations["delete_exemplars"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/exemplars/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One training image. */
        get: operations["get_exemplar"];
        put?: never;
        post?: never;
        /** Delete one training image. Versions trained with it stay as they are. */
        delete: operations["delete_exemplar"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/exemplars/{id}/image": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The picture of a training image, byte for byte as it was sent. */
        get: operations["get_exemplar_image"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/exemplars:batch": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Add many training images: a form with a part `manifest` and then one part named as each file, or a tar archive of
         *     `<label>/<anything>.png|jpg` (a leaf name `…__<degrees>.<ext>` gives the pose).
         */
        post: operations["add_exemplar_batch"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/recognitions": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Recognise one frame. With `Accept: image/png` the answer is the frame with the evidence drawn on it (points and votes,
         *     or candidates and pose); the headers `X-Version` and `X-Digest` say what answered. With
         *     `Accept: image/png; view=reconstruction` (kind `objects`) it is what the version's eigenspace makes of the frame, three
         *     pictures beside each other: the appearance that is looked at, the same rebuilt from eigenimages, and the residual about
         *     mid-gray, whose length is `X-Distance-From-Space`.
         */
        post: operations["recognise"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/recognitions:batch": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Recognise several frames: parts that are all called `image`. One bad picture never loses the rest. */
        post: operations["recognise_batch"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/tracks": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The live tracks of a database, in the order in which they began. */
        get: operations["list_tracks"];
        put?: never;
        /**
         * Begin a track: before its first frame the robot may be anywhere. Tracks live in the memory of the process that began
         *     them, until they are deleted or no frame comes for ten minutes.
         */
        post: operations["begin_track"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/tracks/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One track with what is believed. Looking at it doesn't keep it alive. */
        get: operations["get_track"];
        put?: never;
        post?: never;
        /** End a track. */
        delete: operations["end_track"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/tracks/{id}/frames": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Add a robot's next frame to its track, and say where the robot is by all of them. Frames of a track are taken one by
         *     one, in the order in which they come. The last frame sent again, by a robot that got no answer, isn't counted twice.
         *     When the alias moves to another version, the track goes on with that one.
         */
        post: operations["add_frame"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/trainings": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Train the database's exemplars into a version: answers at once with a job. */
        post: operations["begin_training"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/versions": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Versions by number. */
        get: operations["list_versions"];
        put?: never;
        /** Take in an artifact file: checked whole, then a new version. The same digest again is the same version. */
        post: operations["import_version"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/versions/{version}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One version with its report. */
        get: operations["get_version"];
        put?: never;
        post?: never;
        /** Delete a version that no alias points to. */
        delete: operations["delete_version"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/versions/{version}/artifact": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The version as one file (safetensors): a backup, or another site's database. */
        get: operations["get_version_artifact"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/databases/{database}/versions/{version}/eigenimages/{image}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The mean appearance of an object database, or an eigenimage of its universal eigenspace: zero is mid-gray. */
        get: operations["get_eigenimage"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/depth-maps": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * The distance of everything from a near- and a far-focused picture. `Accept` chooses the form: a summary; a 16-bit
         *     PNG (distance = grey level × `X-Depth-Scale-Mm`, 0 = unknown); an array for NumPy; a point cloud in metres; or, for
         *     people, a picture in false colours (near is red). Pictures must be linear in light.
         */
        post: operations["measure_depth"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/info": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** What this service is and what it takes. */
        get: operations["info"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/jobs": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Jobs, the newest first. */
        get: operations["list_jobs"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/jobs/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One job. */
        get: operations["get_job"];
        put?: never;
        post?: never;
        /** Cancel a job: a waiting one at once, a running one at its next step. */
        delete: operations["cancel_job"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/jobs/{id}/events": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * A job's life as server-sent events: each the job's body, from its first state on. `id` counts up, `Last-Event-ID`
         *     resumes after it, and the stream ends after the last state.
         */
        get: operations["follow_job"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/keys": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Keys, revoked ones too, the oldest first. */
        get: operations["list_keys"];
        put?: never;
        /**
         * Make a key. It is shown in this answer, and never again. The first one is made with `landmarkd keys create`; from then
         *     on every call needs one.
         */
        post: operations["create_key"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/keys/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One key. */
        get: operations["get_key"];
        put?: never;
        post?: never;
        /**
         * Revoke a key, for good. Every process of a fleet refuses it at once; one that is cut off from the catalogue, when
         *     it can reach it again.
         */
        delete: operations["revoke_key"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/segmentations": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Take a picture apart into regions and background. `Accept` chooses the form: the regions; a 16-bit label image
         *     (the region's id for each pixel, 0 is background); or, for people, the picture with outlines, boxes, axes and ids.
         *     A picture in which nothing stands out is an answer without regions.
         */
        post: operations["segment"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/workcells": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Workcells by name. */
        get: operations["list_workcells"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/workcells/{name}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** One workcell. */
        get: operations["get_workcell"];
        /**
         * Describe a workcell; one of that name is replaced. The database must be there, trained or not, and of kind
         *     `objects`; so must the calibration, if one is named.
         */
        put: operations["put_workcell"];
        post?: never;
        /** Delete a workcell. Its database and calibration stay. */
        delete: operations["delete_workcell"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/workcells/{name}/centrings": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Look with the camera at the gripper: by how much it is off the part nearest the picture's middle. Move by it, and
         *     ask again until `centred`.
         */
        post: operations["centre"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/workcells/{name}/inspections": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Find every part on the table, say what it is, how it is turned and where to reach; with a focal pair, how far away
         *     it is. Parts that are nothing known have no decision, and are answered too. With `Accept: image/png` the answer is
         *     the picture with the parts drawn on it; the headers `X-Version` and `X-Digest` say what answered.
         */
        post: operations["inspect"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
}
export type webhooks = Record<string, never>;
export interface components {
    schemas: {
        /** @description An alias. */
        AliasBody: {
            alias: string;
            /** Format: int64 */
            version: number;
            /** Format: date-time */
            updated_at: string;
        };
        /** @description Alive. */
        Alive: {
            /** @example alive */
            status: string;
        };
        /** @description An entry of the record. */
        AuditBody: {
            /**
             * Format: int64
             * @description Grows with every entry; one of a change that was undone may be missing.
             */
            id: number;
            /** Format: date-time */
            at: string;
            /** @description Id of the key that the call came with. */
            key?: string | null;
            /**
             * @description The key's name; without a key `anyone`, `command line`, or `job` and its id.
             * @example robot 7
             */
            actor: string;
            /** @description `X-Request-Id` of the call. */
            request_id?: string | null;
            /** @example alias.set */
            action: string;
            database?: string | null;
            /**
             * @description What of it: an alias, a version's number, an exemplar's id, a key's id.
             * @example current
             */
            subject?: string | null;
            /** @description More about it, as the action has it. */
            detail: Record<string, never>;
        };
        /**
         * @description Done by itself, or not at all.
         * @enum {string}
         */
        AutoOrNoneWord: "auto" | "none";
        /**
         * @description Left to the service.
         * @enum {string}
         */
        AutoWord: "auto";
        /** @description What became of a batch. */
        BatchBody: {
            /** Format: int64 */
            created: number;
            /** Format: int64 */
            duplicates: number;
            /** Format: int64 */
            rejected: number;
            /** @description One for each file, in the order they came. */
            items: components["schemas"]["BatchItem"][];
        };
        /** @description A form with a manifest and one file part for each of its files. */
        BatchForm: {
            /** @description JSON: which file shows what. Best sent first: what comes before it must be held. */
            manifest: components["schemas"]["ManifestLine"][];
        };
        /** @description What became of one file. */
        BatchItem: {
            file: string;
            status: components["schemas"]["ItemStatus"];
            /**
             * Format: uuid
             * @description The exemplar that it is.
             */
            id?: string | null;
            problem?: components["schemas"]["Problem"] | null;
        };
        /** @description Where a robot is, by all its frames so far. */
        BeliefBody: {
            decision?: components["schemas"]["DecisionBody"] | null;
            /** @description The likeliest labels, best first. */
            belief: components["schemas"]["LabelBeliefBody"][];
            /**
             * Format: double
             * @description Probability of being where no exemplar was taken.
             */
            elsewhere: number;
        };
        /** @description What is known of a rig: its optics, and what was measured with it. */
        CalibrationBody: {
            name: string;
            /**
             * Format: int32
             * @description Version of the document's shape.
             */
            version: number;
            image?: components["schemas"]["ImageBody"] | null;
            /** @description What it is measured by: as described, or fitted to a sweep. */
            optics: components["schemas"]["OpticsBody"];
            stated_optics?: components["schemas"]["OpticsBody"] | null;
            registration?: components["schemas"]["RegistrationBody"] | null;
            photometric?: components["schemas"]["PhotometricBody"] | null;
            noise?: components["schemas"]["NoiseBody"] | null;
            filters?: components["schemas"]["FiltersBody"] | null;
            table?: components["schemas"]["TableBody"] | null;
            residual?: components["schemas"]["ResidualBody"] | null;
            /**
             * Format: double
             * @description The distance that the near-focused picture is focused at.
             */
            near_focus_mm: number;
            /**
             * Format: double
             * @description The distance that the far-focused picture is focused at.
             */
            far_focus_mm: number;
            /**
             * Format: double
             * @description From the near to the far focus distance: the working range.
             */
            range_mm: number;
            /**
             * Format: double
             * @description The largest blur within the working range.
             */
            largest_blur_px: number;
            /** @description What would make it better, for people. */
            advice: string[];
            /** Format: date-time */
            created_at: string;
            /** Format: date-time */
            updated_at: string;
        };
        /**
         * @description An object that was looked at closely. Distances are between pictures of unit energy: 0 is equal, √2 nothing in
         *     common.
         */
        CandidateBody: {
            label: string;
            /**
             * Format: double
             * @description From the nearest point of the object's curve of views, in the eigenspace.
             */
            distance_in_space: number;
            /**
             * Format: double
             * @description What of the picture the eigenspace can't express.
             */
            distance_from_space: number;
            /**
             * Format: double
             * @description The largest total distance √(in² + from²) that is accepted as this object; null while it isn't calibrated.
             */
            threshold?: number | null;
            /**
             * Format: double
             * @description By the covariance of the object's views; with `distance: "mahalanobis"` only.
             */
            mahalanobis?: number | null;
        };
        /** @description By how much the part nearest the picture's middle is off it. */
        CentringBody: {
            workcell: string;
            header: components["schemas"]["HeaderEcho"];
            /** @description The region nearest the middle. */
            region: components["schemas"]["RegionBody"];
            /** @description Its centroid less the picture's middle, x and y. */
            move_px: number[];
            /**
             * @description By how much the gripper must move to have it in the middle, X and Y; null while the workcell says nothing of the
             *     local camera.
             */
            move_mm?: number[] | null;
            /** @description Whether it is within the workcell's tolerance. */
            centred: boolean;
            /**
             * Format: double
             * @description How far it is off the middle.
             */
            distance_px: number;
            timings_ms: components["schemas"]["SegmentationTimings"];
        };
        /**
         * @description Which planes signatures are taken from.
         * @enum {string}
         */
        ColourWord: "auto" | "gray" | "opponent";
        /**
         * @description A trained version and the one that `current` pointed to, shown the same: exemplars of the new one, seen otherwise.
         *     Landmarks are also shown with their label left out of either version, when the right answer is null.
         */
        ComparisonBody: {
            /**
             * Format: int64
             * @description The version in use; null if `current` pointed to none that loads: then nothing was shown, and it is promoted.
             */
            against_version?: number | null;
            /**
             * Format: int64
             * @description How often both were asked.
             */
            trials: number;
            /**
             * Format: int64
             * @description Right answers of the trained version.
             */
            candidate_right: number;
            /**
             * Format: int64
             * @description Right answers of the version in use.
             */
            current_right: number;
            /**
             * Format: int64
             * @description Asked when the trained version alone was right.
             */
            candidate_only: number;
            /**
             * Format: int64
             * @description Asked when the version in use alone was right.
             */
            current_only: number;
            /**
             * Format: double
             * @description The chance that, of those on which they differ, as many or more go to the version in use if both are equally
             *     good (sign test). Below 0.05 the trained version counts as worse.
             */
            p_value: number;
            /** @description Whether `current` moved to the trained version. */
            promoted: boolean;
        };
        /** @description Left-out views of one object that were given one wrong answer. */
        ConfusionBody: {
            /** @description The object shown. */
            shown: string;
            /** @description The object named; null when none was. */
            named?: string | null;
            /** Format: int64 */
            times: number;
        };
        /** @description A pixel of the overview camera and the place on the table that it shows. */
        CorrespondenceBody: {
            /** @description x and y. */
            image_px: number[];
            /** @description X and Y. */
            robot_mm: number[];
        };
        /** @description What a version was trained from. */
        CountsBody: {
            /** Format: int64 */
            exemplars: number;
            /** Format: int64 */
            labels: number;
            /**
             * Format: int64
             * @description 0 for objects.
             */
            interest_points: number;
        };
        /** @description A database. */
        DatabaseBody: {
            name: string;
            kind: components["schemas"]["KindWord"];
            /** @description Options of the next training. */
            options: components["schemas"]["OptionsBody"];
            /** Format: date-time */
            created_at: string;
        };
        /** @description A database with what it holds. */
        DatabaseDetail: components["schemas"]["DatabaseBody"] & {
            /**
             * Format: int64
             * @description Training images.
             */
            exemplars: number;
            /**
             * Format: int64
             * @description Distinct labels among them.
             */
            labels: number;
            /**
             * Format: int64
             * @description Trained versions.
             */
            versions: number;
            /**
             * Format: int64
             * @description The version that `current` points to.
             */
            current_version?: number | null;
            aliases: components["schemas"]["AliasBody"][];
        };
        /** @description A database as this process serves it. */
        DatabaseReady: {
            database: string;
            /**
             * Format: int64
             * @description The version that `current` answers with.
             */
            version?: number | null;
            state: components["schemas"]["ReadyStatus"];
            /** @description Why it is degraded. */
            reason?: string | null;
        };
        /** @description What the frame shows. */
        DecisionBody: {
            label: string;
            /**
             * Format: double
             * @description Probability of being right; null while the version isn't calibrated.
             */
            confidence?: number | null;
        };
        /** @description A near- and a far-focused picture, and what the lens is. Either `optics` or `calibration`. */
        DepthForm: {
            /**
             * Format: binary
             * @description The near-focused picture.
             */
            near: Blob;
            /**
             * Format: binary
             * @description The far-focused picture.
             */
            far: Blob;
            optics?: components["schemas"]["OpticsBody"] | null;
            /** @description Name of a calibration. */
            calibration?: string | null;
            options?: components["schemas"]["DepthOptionsBody"] | null;
        };
        /** @description How far away everything is, in short. */
        DepthMapBody: {
            header: components["schemas"]["HeaderEcho"];
            method: components["schemas"]["DepthMethodWord"];
            window: components["schemas"]["WindowBody"];
            /** @description The calibration that was used; null when the form had the optics. */
            calibration?: string | null;
            width_px: number;
            height_px: number;
            /**
             * Format: double
             * @description The distance that the near-focused picture is focused at.
             */
            near_focus_mm: number;
            /**
             * Format: double
             * @description The distance that the far-focused picture is focused at.
             */
            far_focus_mm: number;
            /**
             * Format: double
             * @description From the near to the far focus distance: the working range.
             */
            range_mm: number;
            /**
             * Format: double
             * @description The largest blur within the working range.
             */
            largest_blur_px: number;
            /**
             * Format: double
             * @description Part of the pixels that have a depth.
             */
            coverage: number;
            depth_mm?: components["schemas"]["DepthSpanBody"] | null;
            /**
             * Format: double
             * @description Noise of a picture in grey levels of 255, as the method sees it; null if it can't.
             */
            noise_sigma?: number | null;
            /** @description By how much the far-focused picture was displaced; it was moved back. */
            shift_px: number[];
            /**
             * Format: double
             * @description What the far-focused picture was multiplied by.
             */
            gain: number;
            /**
             * @description Pixels without a depth, by the reason: `low_texture`, `saturated`, `out_of_range`, `inconsistent`, `border`,
             *     `ambiguous`.
             */
            flags: {
                [key: string]: number;
            };
            /**
             * @description Reasons to doubt the whole: `shifted`, `shift_unknown`, `gain_off`, `many_inconsistent`, `low_coverage`,
             *     `near_far_swapped`.
             */
            warnings: string[];
            timings_ms: components["schemas"]["DepthTimings"];
        };
        /**
         * @description What depth is read from: `gram`, the depth that explains both pictures best; `stm`, a closed form, the
         *     cheapest; `laplacian`, the paper's, which needs a calibration with a sweep by this method.
         * @enum {string}
         */
        DepthMethodWord: "gram" | "laplacian" | "stm";
        /** @description Options of a depth map. What is absent has its default. */
        DepthOptionsBody: {
            method?: components["schemas"]["DepthMethodWord"] | null;
            window?: components["schemas"]["WindowBody"] | null;
            align?: components["schemas"]["AutoOrNoneWord"] | null;
            photometric?: components["schemas"]["AutoOrNoneWord"] | null;
            /**
             * Format: int32
             * @description Side of a median over the depths: 0 (none, the default), 3 or 5.
             * @default 0
             */
            median: number | null;
        };
        /** @description Depths of the pixels that have one. */
        DepthSpanBody: {
            /** Format: double */
            min: number;
            /** Format: double */
            median: number;
            /** Format: double */
            max: number;
        };
        /** @description How long the parts of a depth map took, in milliseconds. */
        DepthTimings: {
            /**
             * Format: double
             * @description Waiting for a computing thread.
             */
            queue: number;
            /**
             * Format: double
             * @description Making filters ready; next to nothing when the same optics and options were used lately.
             */
            design: number;
            /** Format: double */
            decode: number;
            /**
             * Format: double
             * @description All that follows decoding: the sum of the four below.
             */
            total: number;
            /**
             * Format: double
             * @description Scale and shift.
             */
            register: number;
            /**
             * Format: double
             * @description Brightness, and halving.
             */
            match: number;
            /**
             * Format: double
             * @description Filters and windows.
             */
            estimate: number;
            /**
             * Format: double
             * @description Choice of windows, lens law, flags.
             */
            judge: number;
        };
        /** @description A number of coordinates, or `auto`: the least that recognises held-out views as well as any. */
        DimensionBody: number | components["schemas"]["AutoWord"];
        /** @description Left-out views recognised at a dimension. */
        DimensionRateBody: {
            /** Format: int64 */
            dimension: number;
            /** Format: int64 */
            right: number;
            /** Format: int64 */
            trials: number;
        };
        /**
         * @description By what the universal eigenspace orders objects.
         * @enum {string}
         */
        DistanceWord: "euclidean" | "mahalanobis";
        /** @description What speaks for the answer, by the kind of the database. */
        EvidenceBody: components["schemas"]["LandmarkEvidence"] | components["schemas"]["ObjectEvidence"];
        /** @description A training image. */
        ExemplarBody: {
            /** Format: uuid */
            id: string;
            label: string;
            /** Format: double */
            pose_deg?: number | null;
            /** Format: int32 */
            width_px: number;
            /** Format: int32 */
            height_px: number;
            /**
             * Format: int64
             * @description Size of the picture as sent.
             */
            bytes: number;
            /** @description SHA-256 of the picture as sent. */
            sha256: string;
            media_type: string;
            /** Format: date-time */
            created_at: string;
            header: components["schemas"]["HeaderEcho"];
        };
        /** @description A field that is at fault. */
        FieldError: {
            /**
             * @description JSON pointer (RFC 6901) into the body, or the name of the query or path parameter after `#`.
             * @example /options/rings
             */
            pointer: string;
            /** @description What is wrong with it. */
            detail: string;
        };
        /** @description The filters that the table was measured with. */
        FiltersBody: {
            method: components["schemas"]["DepthMethodWord"];
            /** @description Side of the kernels. */
            K: number;
            /** @description Pairs of kernels. */
            J: number;
            /**
             * Format: double
             * @description Highest frequency that they let pass, cycles a pixel.
             */
            band: number;
            /**
             * Format: int32
             * @description By how much the pictures are shrunk first.
             */
            scale: number;
            hash: string;
        };
        /** @description A frame of a track. */
        FrameBody: {
            /**
             * Format: int64
             * @description Its number in the track, from 1.
             */
            number: number;
            /** @description False when it was the last frame sent again (the same `X-Frame-Id`, header and picture): the belief is as it was. */
            counted: boolean;
            decision?: components["schemas"]["DecisionBody"] | null;
        };
        /** @description From one view's pose to the next; across 0 the second is the smaller one. */
        GapBody: {
            /** Format: double */
            from_deg: number;
            /** Format: double */
            to_deg: number;
        };
        /** @description What the robot says about its frame, as an answer echoes it. */
        HeaderEcho: {
            /** @description `X-Robot-Id` as sent. */
            robot_id?: string | null;
            /** @description `X-Frame-Id` as sent. */
            frame_id?: string | null;
            /** @description `X-Stamp` as sent: RFC 3339 or `sec.nanosec`. */
            stamp?: string | null;
        };
        /**
         * @description Each view in turn was left out of its object and shown, and was shown to the other objects alone. The threshold was
         *     chosen on the same views: others may fare worse.
         */
        HeldOutBody: {
            /**
             * Format: int64
             * @description Views of objects with at least two.
             */
            known: number;
            /**
             * Format: int64
             * @description Of these, accepted as something.
             */
            known_accepted: number;
            /**
             * Format: int64
             * @description Of these, named right.
             */
            known_right: number;
            /**
             * Format: int64
             * @description Views shown to the other objects alone.
             */
            unknown: number;
            /**
             * Format: int64
             * @description Of these, refused.
             */
            unknown_refused: number;
        };
        /** @description Size of the pictures in pixels, and bits a sample. */
        ImageBody: {
            width: number;
            height: number;
            /** Format: int32 */
            bits: number;
        };
        /** @description A form with one picture. */
        ImageForm: {
            /**
             * Format: binary
             * @description The picture.
             */
            image: Blob;
        };
        /** @description A form with several pictures. */
        ImagesForm: {
            /** @description The pictures: parts that are all called `image`. */
            image: string[];
        };
        /** @description What this service is and what it takes. */
        Info: {
            /** @example landmarkd */
            name: string;
            /** @description Release. */
            version: string;
            /**
             * Format: int64
             * @description Algorithm revision: versions of another revision come from another method.
             */
            revision: number;
            limits: components["schemas"]["LimitsBody"];
            /** @description Media types of the pictures that are read. */
            formats: string[];
            /** Format: date-time */
            started_at: string;
            /** @description The name under which this process does jobs. */
            worker: string;
            /**
             * @description Its part of a fleet's work.
             * @example all
             */
            role: string;
            /**
             * @description The processes that share the catalogue and what each serves, this one first: as they told within the last
             *     ten seconds. With the catalogue away, this one alone.
             */
            processes: components["schemas"]["ProcessBody"][];
        };
        /** @description What stands on the table. */
        InspectionBody: {
            workcell: string;
            database: string;
            /**
             * Format: int64
             * @description The version that answered.
             */
            version: number;
            digest: string;
            /** @description The calibration that distances were measured with; null without a pair. */
            calibration?: string | null;
            header: components["schemas"]["HeaderEcho"];
            width_px: number;
            height_px: number;
            /** @description Regions of at least the least area, also those beyond `max_objects`. */
            regions_found: number;
            /** @description One for each region, the largest first; also those that are nothing known. */
            objects: components["schemas"]["PartBody"][];
            /**
             * @description `no_region`: nothing stands out. `more_regions`: there are more than `max_objects`. `not_segmented`: the version
             *     was trained without `segment`, so that its pictures were made by another recipe than the parts are cut out by.
             *     `no_region_in_pair`: nothing stands out in the near-focused picture. Those of a depth map with `depth_` before.
             */
            warnings: string[];
            timings_ms: components["schemas"]["InspectionTimings"];
        };
        /** @description The table, and with `near` and `far` a focal pair of a part or of the table. */
        InspectionForm: {
            /**
             * Format: binary
             * @description The overview camera's picture.
             */
            overview: Blob;
            /**
             * Format: binary
             * @description The near-focused picture; with `far`, and a calibration in the workcell.
             */
            near?: Blob | null;
            /**
             * Format: binary
             * @description The far-focused picture.
             */
            far?: Blob | null;
        };
        /** @description How long the parts of an inspection took, in milliseconds. */
        InspectionTimings: {
            /**
             * Format: double
             * @description Waiting for a computing thread.
             */
            queue: number;
            /** Format: double */
            decode: number;
            /** Format: double */
            segment: number;
            /**
             * Format: double
             * @description Cutting out, centring and scaling of all parts.
             */
            cut: number;
            /**
             * Format: double
             * @description Which objects, and how turned.
             */
            recognise: number;
            /**
             * Format: double
             * @description Making filters ready; next to nothing when the same calibration was used lately.
             */
            design: number;
            /**
             * Format: double
             * @description The depth map, and the distances of the parts.
             */
            depth: number;
            /**
             * Format: double
             * @description All that follows decoding: the sum of the five before.
             */
            total: number;
        };
        /** @description Something known that is in the frame. */
        InstanceBody: {
            label: string;
            /**
             * Format: double
             * @description Probability of being right.
             */
            confidence: number;
            placement: components["schemas"]["PlacementBody"];
        };
        /**
         * @description Whether a file became an exemplar.
         * @enum {string}
         */
        ItemStatus: "created" | "duplicate" | "rejected";
        /** @description A piece of long work. */
        JobBody: {
            /** Format: uuid */
            id: string;
            /** @example training */
            kind: string;
            /** @description The database that it is about; null for a sweep. */
            database?: string | null;
            /** @description The calibration that it is about; null for a training. */
            calibration?: string | null;
            state: components["schemas"]["StateWord"];
            progress?: components["schemas"]["ProgressBody"] | null;
            /**
             * Format: int64
             * @description The version it made or found.
             */
            version?: number | null;
            comparison?: components["schemas"]["ComparisonBody"] | null;
            problem?: components["schemas"]["Problem"] | null;
            /** @description Who does it, or did it last. */
            worker?: string | null;
            /**
             * Format: int32
             * @description How often it was begun.
             */
            attempts: number;
            /** Format: date-time */
            created_at: string;
            /** Format: date-time */
            started_at?: string | null;
            /** Format: date-time */
            finished_at?: string | null;
        };
        /** @description One event of a job's life. */
        JobEvent: {
            /** @description Its number. */
            id: string;
            /** @description The job as JSON. */
            data: string;
        };
        /** @description A key, without its secret. */
        KeyBody: {
            /** @example 2f6b1c09d4e7a853 */
            id: string;
            name: string;
            scope: components["schemas"]["ScopeWord"];
            databases?: string[] | null;
            /** Format: int64 */
            requests_per_s?: number | null;
            /** Format: date-time */
            created_at: string;
            /**
             * Format: date-time
             * @description Of other processes within a minute or so.
             */
            last_used_at?: string | null;
            /**
             * Format: date-time
             * @description It isn't taken any more from then on.
             */
            revoked_at?: string | null;
        };
        /** @description A new key, shown this once. */
        KeyMade: components["schemas"]["KeyBody"] & {
            /**
             * @description The key itself: keep it, it isn't shown again.
             * @example lmk_2f6b1c09d4e7a853_…
             */
            key: string;
        };
        /**
         * @description What a database recognises by.
         * @enum {string}
         */
        KindWord: "landmarks" | "objects";
        /** @description The belief in a label. */
        LabelBeliefBody: {
            label: string;
            /**
             * Format: double
             * @description Probability of being at one of its exemplars.
             */
            probability: number;
            /** @description Id of the likeliest of them. */
            exemplar: string;
        };
        /** @description What speaks for the answer of a landmark database. */
        LandmarkEvidence: {
            /** @description The evidence, best first. */
            votes: components["schemas"]["VoteBody"][];
            /**
             * @description Everything known that is in the frame for sure enough, surest first: several things, or one several times. Empty
             *     where answers have no confidence, or no placement.
             */
            instances: components["schemas"]["InstanceBody"][];
            /**
             * Format: int64
             * @description Interest points that were asked: no more than it takes.
             */
            points_used: number;
            /**
             * Format: int64
             * @description Interest points in the frame.
             */
            points_found: number;
            /** @description With `explain`: every point's vote, most salient first. For each label the weights sum to its W. */
            points?: components["schemas"]["PointBody"][] | null;
        };
        /**
         * @description Options of a database of kind `landmarks`. Defaults are those of `method` and `viewpoint`: a body that names another
         *     of these than the database has starts from that pair's defaults, and its other members are put over them.
         */
        LandmarkOptionsBody: {
            method?: components["schemas"]["MethodWord"] | null;
            viewpoint?: components["schemas"]["ViewpointWord"] | null;
            operator?: components["schemas"]["OperatorWord"] | null;
            /** @description Radius of the symmetry operator. */
            symmetry_radius_px?: number | null;
            /** @description Interest points an exemplar. */
            interest_points?: number | null;
            /** @description Interest points a query frame. */
            query_points?: number | null;
            subwindow_radius_px?: components["schemas"]["RadiiBody"] | null;
            /** @description Rows of a polar sub-window. */
            rings?: number | null;
            /** @description Columns of a polar sub-window. */
            sectors?: number | null;
            taper?: components["schemas"]["TaperWord"] | null;
            normalise?: components["schemas"]["NormaliseWord"] | null;
            colour?: components["schemas"]["ColourWord"] | null;
            /** @description Dimension of the eigenspace. */
            dimension?: number | null;
            /** @description Nearest eigenpoints that each sub-window of a frame is matched with; the paper's method has one. */
            neighbours?: number | null;
            /**
             * Format: double
             * @description ε of the vote 1/(D+ε).
             */
            epsilon?: number | null;
            per_label?: components["schemas"]["PerLabelWord"] | null;
            /**
             * Format: double
             * @description Upright: a window is believed to be seen within some such distance of where it was; null: anywhere.
             */
            position_prior_px?: number | null;
        };
        /** @description What the training of a landmark database told of itself. */
        LandmarkReportBody: {
            /** @description Variance along each direction of the signatures' space, descending, all of them. */
            spectrum: number[];
            /**
             * Format: double
             * @description Part of the variance that the kept dimensions hold.
             */
            energy_kept: number;
            /**
             * Format: int64
             * @description Dimensions kept.
             */
            dimension: number;
            /**
             * Format: int64
             * @description Components of a signature.
             */
            signature_length: number;
            /**
             * @description The planes that signatures were taken from.
             * @example opponent
             */
            colour: string;
            /** @description Exemplars in which nothing drew attention: they can't be recognised. */
            exemplars_without_points: string[];
            reliability?: components["schemas"]["ReliabilityBody"] | null;
            /**
             * @description What the training has to say: `not_calibrated` if no exemplar was recognised when it was seen otherwise, so that
             *     answers have no confidence.
             */
            warnings: string[];
            timings_ms?: components["schemas"]["TrainingTimings"] | null;
        };
        /** @description The parts of a recognition by landmarks, in milliseconds. */
        LandmarkStages: {
            /**
             * Format: double
             * @description Interest points.
             */
            attention: number;
            /**
             * Format: double
             * @description Sub-windows and their spectra.
             */
            signature: number;
            /**
             * Format: double
             * @description Projection and nearest eigenpoints.
             */
            search: number;
            /** Format: double */
            vote: number;
            /**
             * Format: double
             * @description Laying exemplars on the frame.
             */
            verification: number;
        };
        /** @description What is refused. */
        LimitsBody: {
            /** Format: int64 */
            max_body_bytes: number;
            /** Format: int32 */
            max_side_px: number;
            /** Format: int64 */
            max_pixels: number;
            /** Format: int64 */
            max_decode_bytes: number;
            /** Format: int64 */
            max_decode_bytes_total: number;
            /** Format: int64 */
            max_body_bytes_total: number;
            /** Format: int64 */
            max_batch_parts: number;
            /** Format: int64 */
            max_batch_bytes: number;
            /** Format: int64 */
            max_artifact_bytes: number;
            /** Format: int64 */
            max_tracks: number;
            /** Format: int64 */
            max_tracks_bytes: number;
            /** Format: int64 */
            track_idle_ms: number;
            /** Format: int64 */
            max_waiting: number;
            /** Format: int64 */
            threads: number;
            /** Format: int64 */
            request_timeout_ms: number;
            /** Format: int64 */
            max_connections: number;
            /** Format: int64 */
            header_timeout_ms: number;
            /** Format: int64 */
            body_timeout_ms: number;
            /** Format: int64 */
            idle_timeout_ms: number;
            /** Format: int64 */
            write_timeout_ms: number;
        };
        /** @description The camera at the gripper. */
        LocalCameraBody: {
            /**
             * Format: double
             * @description Scale on the table.
             */
            mm_per_px: number;
            /**
             * Format: double
             * @description Direction of the image's x axis in the robot's plane, from X towards Y.
             */
            rotation_deg?: number;
        };
        /** @description One line of a batch's manifest. */
        ManifestLine: {
            /** @description Name of the file part. */
            file: string;
            /** @description The place or object. */
            label: string;
            /**
             * Format: double
             * @description Turntable pose, in degrees.
             */
            pose_deg?: number | null;
        };
        /** @description From the overview camera's pixels to the robot. */
        MappingBody: {
            kind: components["schemas"]["MappingKindWord"];
            /** @description Row by row: (X·w, Y·w, w) = matrix · (x, y, 1), in mm and pixels. */
            matrix: number[][];
            /**
             * Format: double
             * @description Root mean square distance of the correspondences from where the mapping puts them.
             */
            residual_mm: number;
        };
        /**
         * @description What a mapping keeps: shapes (turned, scaled and moved); parallels; straight lines (a camera that looks aslant).
         * @enum {string}
         */
        MappingKindWord: "similarity" | "affine" | "homography";
        /**
         * @description How matches become an answer: by agreeing on where an exemplar lies and how it is turned (`placement`), or by
         *     each point's vote for the exemplar of its nearest eigenpoint, the published method (`paper`).
         * @enum {string}
         */
        MethodWord: "placement" | "paper";
        /**
         * @description How robots move among the exemplars.
         * @enum {string}
         */
        MotionWord: "path" | "still" | "auto";
        /** @description Where an alias shall point. */
        NewAlias: {
            /**
             * Format: int64
             * @description Number of a version that loads.
             */
            version: number;
        };
        /** @description A database to create. */
        NewDatabase: {
            kind: components["schemas"]["KindWord"];
            options?: components["schemas"]["OptionsBody"] | null;
        };
        /** @description A key to make. */
        NewKeyBody: {
            /**
             * @description For people: whose key it is.
             * @example robot 7
             */
            name: string;
            scope: components["schemas"]["ScopeWord"];
            /**
             * @description Names of the databases that it reaches, with `*` and `?`; null: every one.
             * @example [
             *       "floor-*"
             *     ]
             */
            databases?: string[] | null;
            /**
             * Format: int32
             * @description Most calls a second, to each process; null: as many as there is time for.
             */
            requests_per_s?: number | null;
        };
        /** @description A track to begin. */
        NewTrack: {
            /**
             * @description How robots move among the exemplars.
             * @default auto
             */
            motion: components["schemas"]["MotionWord"];
            /** @description The alias whose version answers; `current` when it isn't given. */
            alias?: string | null;
        };
        /** @description A training to do. */
        NewTraining: {
            options?: components["schemas"]["OptionsBody"] | null;
            /**
             * @description Whether `current` moves to the new version.
             * @default always
             */
            promote: components["schemas"]["PromoteWord"];
        };
        /** @description Noise of a pixel: variance = read_sigma² + shot_gain · level, in grey levels of 255. */
        NoiseBody: {
            /** Format: double */
            read_sigma: number;
            /** Format: double */
            shot_gain: number;
        };
        /**
         * @description What is made equal between sub-windows before the transform.
         * @enum {string}
         */
        NormaliseWord: "contrast" | "energy" | "none";
        /** @description What speaks for the answer of an object database. */
        ObjectEvidence: {
            /** @description The objects that were looked at closely, the likeliest first. */
            candidates: components["schemas"]["CandidateBody"][];
            pose?: components["schemas"]["PoseBody"] | null;
        };
        /** @description Options of a database of kind `objects`. */
        ObjectOptionsBody: {
            /** @description Width of the database's pictures; null, as the height then: the commonest size among the exemplars. */
            width_px?: number | null;
            /** @description Height of the database's pictures. */
            height_px?: number | null;
            resize?: components["schemas"]["ResizeWord"] | null;
            /**
             * Format: double
             * @description Standard deviation of the Gaussian that pictures are smoothed with, as a part of their longer side.
             */
            smoothing?: number | null;
            /**
             * @description Whether the object is cut out of its picture first, in training and in recognition: the largest region that
             *     stands out from the background, in the square about its centroid, on black. Pictures are then square, of 128 px
             *     unless a size is given.
             */
            segment?: boolean | null;
            dimension?: components["schemas"]["DimensionBody"] | null;
            stages?: components["schemas"]["StagesWord"] | null;
            search?: components["schemas"]["SearchWord"] | null;
            distance?: components["schemas"]["DistanceWord"] | null;
            /**
             * Format: double
             * @description Part of the known objects that is to be accepted.
             */
            accept?: number | null;
        };
        /** @description The parts of a recognition by whole appearance, in milliseconds. */
        ObjectStages: {
            /**
             * Format: double
             * @description The picture as a vector.
             */
            appearance: number;
            /**
             * Format: double
             * @description Projection into the universal eigenspace, and the eigenpoints near.
             */
            universal: number;
            /**
             * Format: double
             * @description The likeliest objects' own eigenspaces: which, and how turned.
             */
            object: number;
        };
        /** @description What the training of an object database told of itself. Rates are of views that were left out. */
        ObjectsReportBody: {
            /**
             * @description Variance along the directions of the universal eigenspace, descending; for more than 1500 views the leading
             *     ones.
             */
            spectrum: number[];
            /**
             * Format: double
             * @description Part of the variance that the kept dimensions hold.
             */
            energy_kept: number;
            /**
             * Format: int64
             * @description Dimensions kept.
             */
            dimension: number;
            /**
             * Format: int64
             * @description Width of the database's pictures.
             */
            width_px: number;
            /**
             * Format: int64
             * @description Height of the database's pictures.
             */
            height_px: number;
            /**
             * Format: int64
             * @description Components of an appearance.
             */
            vector_length: number;
            /** @description Left-out views whose nearest eigenpoint is of their own object, by dimension. */
            rate_by_dimension: components["schemas"]["DimensionRateBody"][];
            /** @description Left-out views that were taken for another object, or for none. */
            confusion: components["schemas"]["ConfusionBody"][];
            held_out?: components["schemas"]["HeldOutBody"] | null;
            /** @description By object. */
            objects: components["schemas"]["OneObjectBody"][];
            /** @description Pairs of exemplars that are all but the same picture. */
            near_duplicates: string[][];
            /** @description Pairs of exemplars of one object with one pose: their mean is taken. */
            repeated_poses: string[][];
            /** @description Exemplars with too many pixels as bright as can be. */
            over_exposed: string[];
            /** @description Exemplars with hardly a bright pixel. */
            under_exposed: string[];
            /** @description Exemplars that are black, or in which nothing stands out to be cut out: they were left out. */
            blank: string[];
            /** @description Exemplars that were not of the database's size, and were scaled. */
            resized: string[];
            /** @description With `segment`: exemplars whose object reaches the picture's border, which may cut it. */
            touches_border: string[];
            /** @description With `segment`: exemplars in which another thing is nearly as large; the largest was learnt. */
            several_regions: string[];
            timings_ms?: components["schemas"]["TrainingTimings"] | null;
        };
        /** @description What is known of one object. */
        OneObjectBody: {
            label: string;
            /** Format: int64 */
            views: number;
            /**
             * Format: int64
             * @description Of these, with a pose.
             */
            views_with_pose: number;
            /**
             * Format: double
             * @description The largest total distance that is accepted as this object; null if it could not be told.
             */
            threshold?: number | null;
            pose?: components["schemas"]["PoseErrorsBody"] | null;
            /** @description Poses that no view is near: the pose isn't reliable there. */
            gaps: components["schemas"]["GapBody"][];
        };
        /**
         * @description What draws attention: generalised symmetry, as in the paper, or corners (Harris): fewer points, on objects as
         *     good, on places not.
         * @enum {string}
         */
        OperatorWord: "symmetry" | "harris";
        /**
         * @description One lens before two sensors. Exactly one of `aperture_mm` and `f_number`, and exactly one of `near_plane_mm` and
         *     `near_focus_mm`.
         */
        OpticsBody: {
            /** Format: double */
            focal_length_mm: number;
            /**
             * Format: double
             * @description Diameter of the aperture.
             */
            aperture_mm?: number | null;
            /**
             * Format: double
             * @description Focal length over diameter.
             */
            f_number?: number | null;
            /**
             * Format: double
             * @description Distance from the lens to the sensor of the near-focused picture, the farther of the two sensors.
             */
            near_plane_mm?: number | null;
            /**
             * Format: double
             * @description The distance in the scene that the near-focused picture is focused at.
             */
            near_focus_mm?: number | null;
            /**
             * Format: double
             * @description How much nearer to the lens the sensor of the far-focused picture stands.
             */
            plane_separation_mm: number;
            /**
             * Format: double
             * @description Side of a pixel, in µm.
             */
            pixel_pitch_um: number;
            /** @description Whether a stop in the front focal plane keeps both pictures at one scale. */
            telecentric: boolean;
            /** @description Where the optical axis meets the picture; its middle by default. */
            principal_point_px?: number[] | null;
        };
        /** @description Options of a database, by its kind. */
        OptionsBody: components["schemas"]["LandmarkOptionsBody"] | components["schemas"]["ObjectOptionsBody"];
        /** @description A part of a list. */
        Page_AliasBody: {
            /** @description The items, in the list's order. */
            items: components["schemas"]["AliasBody"][];
            /** @description Give this as `cursor` for what follows; null at the end. */
            next_cursor?: string | null;
        };
        /** @description A part of a list. */
        Page_AuditBody: {
            /** @description The items, in the list's order. */
            items: components["schemas"]["AuditBody"][];
            /** @description Give this as `cursor` for what follows; null at the end. */
            next_cursor?: string | null;
        };
        /** @description A part of a list. */
        Page_CalibrationBody: {
            /** @description The items, in the list's order. */
            items: components["schemas"]["CalibrationBody"][];
            /** @description Give this as `cursor` for what follows; null at the end. */
            next_cursor?: string | null;
        };
        /** @description A part of a list. */
        Page_DatabaseBody: {
            /** @description The items, in the list's order. */
            items: components["schemas"]["DatabaseBody"][];
            /** @description Give this as `cursor` for what follows; null at the end. */
            next_cursor?: string | null;
        };
        /** @description A part of a list. */
        Page_ExemplarBody: {
            /** @description The items, in the list's order. */
            items: components["schemas"]["ExemplarBody"][];
            /** @description Give this as `cursor` for what follows; null at the end. */
            next_cursor?: string | null;
        };
        /** @description A part of a list. */
        Page_JobBody: {
            /** @description The items, in the list's order. */
            items: components["schemas"]["JobBody"][];
            /** @description Give this as `cursor` for what follows; null at the end. */
            next_cursor?: string | null;
        };
        /** @description A part of a list. */
        Page_KeyBody: {
            /** @description The items, in the list's order. */
            items: components["schemas"]["KeyBody"][];
            /** @description Give this as `cursor` for what follows; null at the end. */
            next_cursor?: string | null;
        };
        /** @description A part of a list. */
        Page_TrackBody: {
            /** @description The items, in the list's order. */
            items: components["schemas"]["TrackBody"][];
            /** @description Give this as `cursor` for what follows; null at the end. */
            next_cursor?: string | null;
        };
        /** @description A part of a list. */
        Page_VersionBody: {
            /** @description The items, in the list's order. */
            items: components["schemas"]["VersionBody"][];
            /** @description Give this as `cursor` for what follows; null at the end. */
            next_cursor?: string | null;
        };
        /** @description A part of a list. */
        Page_WorkcellBody: {
            /** @description The items, in the list's order. */
            items: components["schemas"]["WorkcellBody"][];
            /** @description Give this as `cursor` for what follows; null at the end. */
            next_cursor?: string | null;
        };
        /** @description A part on the table. */
        PartBody: {
            region: components["schemas"]["RegionBody"];
            /** @description Where its centroid is, X and Y; null beyond the horizon of the mapping. */
            robot_mm?: number[] | null;
            /**
             * Format: double
             * @description Direction of its principal axis, in [-90, 90), from X towards Y; null if it has none.
             */
            robot_deg?: number | null;
            decision?: components["schemas"]["DecisionBody"] | null;
            /** @description The objects that were looked at closely, the likeliest first. */
            candidates: components["schemas"]["CandidateBody"][];
            pose?: components["schemas"]["PoseBody"] | null;
            /**
             * Format: double
             * @description Median of the distances within its region; null if none was measured.
             */
            distance_mm?: number | null;
            /**
             * Format: double
             * @description Standard deviation to be expected of it; null if the method tells none.
             */
            distance_sigma_mm?: number | null;
            /**
             * Format: double
             * @description Part of its pixels that have a distance.
             */
            distance_coverage?: number | null;
            /**
             * @description Those of a recognition: `touches_border` (what is missing may change the answer), `over_exposed`,
             *     `blank_picture`, `beyond_threshold`, `close_second`, `not_calibrated`. `beyond_horizon`: the mapping has no
             *     place for it. `no_depth`: it was looked for, and no pixel of the part has one.
             */
            warnings: string[];
        };
        /**
         * @description How a label's weight is made of its exemplars' weights.
         * @enum {string}
         */
        PerLabelWord: "best" | "sum";
        /** @description Offsets and gain of the two sensors, in grey levels of 255. */
        PhotometricBody: {
            /** Format: double */
            dark_near: number;
            /** Format: double */
            dark_far: number;
            /**
             * Format: double
             * @description What the far-focused picture, without its dark level, is multiplied by.
             */
            gain_far: number;
        };
        /** @description An exemplar laid on the frame. */
        PlacementBody: {
            /**
             * Format: float
             * @description Where the centre of the exemplar's picture is seen.
             */
            x_px: number;
            /** Format: float */
            y_px: number;
            /**
             * Format: float
             * @description How it is turned, in (-180, 180]; positive from x towards y: clockwise as seen on screen.
             */
            rotation_deg: number;
            /**
             * Format: float
             * @description Pixels of the frame for each of the exemplar.
             */
            scale: number;
            /**
             * Format: int64
             * @description Sub-windows of the frame that agree on it.
             */
            inliers: number;
            /**
             * Format: float
             * @description How well the exemplar's gradients are found again in the frame, -1 to 1.
             */
            agreement: number;
            /** @description The corners of the exemplar's picture on the frame, from its top left on clockwise. */
            outline_px: number[][];
            /** @description Id of the exemplar. */
            exemplar: string;
        };
        /** @description One plane of a sweep. */
        PlaneLine: {
            /**
             * Format: double
             * @description Distance of the plane from the lens.
             */
            depth_mm: number;
            /** @description Name of the part with the near-focused picture. */
            near: string;
            /** @description Name of the part with the far-focused picture. */
            far: string;
        };
        /** @description The vote of an interest point. */
        PointBody: {
            /** Format: float */
            x_px: number;
            /** Format: float */
            y_px: number;
            /** Format: float */
            salience: number;
            /** @description Id of the exemplar that it votes for, or whose eigenpoint is nearest. */
            exemplar: string;
            /** @description Its label. */
            label: string;
            /**
             * Format: double
             * @description Distance D in the eigenspace.
             */
            distance: number;
            /**
             * Format: double
             * @description Its part of W: 0 where it counts for nothing; with the paper's method 1/(D+ε).
             */
            weight: number;
        };
        /**
         * @description What objects look like.
         * @enum {string}
         */
        PolarityWord: "light_on_dark" | "dark_on_light";
        /** @description How an object is turned. */
        PoseBody: {
            /**
             * Format: double
             * @description Turn about the vertical, in [0, 360).
             */
            turn_deg: number;
            /**
             * Format: double
             * @description Standard deviation to be expected.
             */
            sigma_deg: number;
            /** @description Whether the pose may be acted on. */
            reliable: boolean;
            /**
             * Format: double
             * @description Another pose that would look the same.
             */
            alternative_deg?: number | null;
        };
        /** @description Errors of the pose of left-out views, which see twice the gap that a picture to recognise sees. */
        PoseErrorsBody: {
            /** Format: int64 */
            trials: number;
            /** Format: double */
            mean_deg: number;
            /** Format: double */
            median_deg: number;
            /** Format: double */
            p95_deg: number;
            /**
             * Format: int64
             * @description How many were within 5°.
             */
            within_5_deg: number;
        };
        /** @description A problem document, `application/problem+json`. */
        Problem: {
            /**
             * Format: uri-reference
             * @description The kind of problem: the address, on this service, of a page that says what to do.
             * @example /problems/not_trained
             */
            type: string;
            /** @description One line on the kind of problem. */
            title: string;
            /**
             * Format: int32
             * @description The HTTP status.
             * @example 409
             */
            status: number;
            /** @description What happened here, and what to do. */
            detail: string;
            /**
             * @description The kind of problem, for programs.
             * @example not_trained
             */
            code: string;
            /** @description The request's id, as in `X-Request-Id`. */
            request_id?: string | null;
            /** @description The fields at fault. */
            errors?: components["schemas"]["FieldError"][];
        };
        /** @description A process, and what it serves. */
        ProcessBody: {
            worker: string;
            /** @example serve */
            role: string;
            /** Format: date-time */
            started_at: string;
            databases: components["schemas"]["DatabaseReady"][];
        };
        /** @description How far a job is. */
        ProgressBody: {
            /** @example describing */
            stage: string;
            /** Format: int64 */
            done: number;
            /** Format: int64 */
            total: number;
        };
        /**
         * @description Whether `current` moves to the new version.
         * @enum {string}
         */
        PromoteWord: "always" | "if_not_worse" | "never";
        /** @description What is known of a workcell. */
        PutWorkcell: {
            /** @description The database that names the parts, of kind `objects`. */
            database: string;
            /** @description The rig that measures distances, for inspections with a focal pair. */
            calibration?: string | null;
            /**
             * @description What the mapping is fitted to: two at the least for a similarity, three for an affine map, four for a
             *     homography; more even out their errors.
             */
            correspondences: components["schemas"]["CorrespondenceBody"][];
            mapping?: components["schemas"]["MappingKindWord"] | null;
            /**
             * @description Whether the robot's Y grows where the image's y falls, as seen by both cameras.
             * @default true
             */
            flip_y: boolean | null;
            local?: components["schemas"]["LocalCameraBody"] | null;
            /**
             * Format: double
             * @description A part counts as centred within so many pixels.
             * @default 1
             */
            tolerance_px: number | null;
            segmentation?: components["schemas"]["SegmentationOptionsBody"] | null;
        };
        /** @description A radius, or one to four different ones, the smallest first. */
        RadiiBody: number | number[];
        /** @description Whether the service answers, and with what. */
        Ready: {
            status: components["schemas"]["ReadyStatus"];
            databases: components["schemas"]["DatabaseReady"][];
            catalogue: components["schemas"]["StoreStatus"];
            blobs: components["schemas"]["StoreStatus"];
        };
        /**
         * @description `degraded` still answers: something is broken, the rest serves.
         * @enum {string}
         */
        ReadyStatus: "ready" | "degraded" | "starting";
        /** @description The answers to a batch, in the order of its pictures. */
        RecognitionBatch: {
            items: components["schemas"]["RecognitionItem"][];
        };
        /** @description What a frame shows. */
        RecognitionBody: components["schemas"]["LandmarkRecognitionBody"] | components["schemas"]["ObjectRecognitionBody"];
        /** @description One item of a batch: a recognition, or the problem with that picture. */
        RecognitionItem: components["schemas"]["RecognitionBody"] | {
            problem: components["schemas"]["Problem"];
        };
        /** @description A connected part of a picture that stands out from its background. */
        RegionBody: {
            /** @description From 1, the largest first; its pixels have this value in the label image. */
            id: number;
            /** @description Its pixels. */
            area_px: number;
            /** @description The mean of its pixels, x and y. */
            centroid_px: number[];
            /** @description x, y, width and height of the smallest upright rectangle around it. */
            bbox_px: number[];
            /**
             * Format: double
             * @description Direction of its principal axis, in [-90, 90), from x towards y; null for one that is as broad as long.
             */
            orientation_deg?: number | null;
            /**
             * Format: double
             * @description Length over breadth, by its second moments.
             */
            elongation: number;
            /** @description Whether the picture cuts it, so that a part of it may be outside. */
            touches_border: boolean;
        };
        /** @description How the far-focused picture is brought into register. */
        RegistrationBody: {
            /** @description a, b, c, d, e, f: the far pixel (a·x + b·y + c, d·x + e·y + f) shows what the near pixel (x, y) shows. */
            affine_far_to_near: number[];
            /**
             * Format: double
             * @description What is left between both.
             */
            rms_px: number;
        };
        /** @description Pictures to register by. */
        RegistrationForm: {
            /**
             * Format: binary
             * @description The near-focused picture of a flat target with fine irregular texture, within the working range.
             */
            near: Blob;
            /**
             * Format: binary
             * @description The far-focused picture of it.
             */
            far: Blob;
            /**
             * Format: binary
             * @description The near-focused sensor's picture in the dark; with `dark_far`.
             */
            dark_near?: Blob | null;
            /** Format: binary */
            dark_far?: Blob | null;
            /**
             * Format: binary
             * @description The near-focused sensor's picture of an evenly lit white surface; with `flat_far`.
             */
            flat_near?: Blob | null;
            /** Format: binary */
            flat_far?: Blob | null;
        };
        /** @description Answers of about the same confidence. */
        ReliabilityBinBody: {
            /**
             * Format: double
             * @description Their mean confidence.
             */
            confidence: number;
            /** Format: int64 */
            answers: number;
            /**
             * Format: double
             * @description Part of them that was right.
             */
            right: number;
        };
        /**
         * @description What the version answered when its exemplars were shown turned, moved, on other ground and partly hidden: as they
         *     are, and again with all of their label left out, when nothing should be recognised.
         */
        ReliabilityBody: {
            /**
             * Format: int64
             * @description Frames that showed something known.
             */
            known: number;
            /**
             * Format: int64
             * @description Frames that showed nothing known.
             */
            unknown: number;
            /**
             * Format: double
             * @description Part of the known ones that were decided rightly.
             */
            known_named: number;
            /**
             * Format: double
             * @description Part of the known ones that were decided wrongly.
             */
            known_misnamed: number;
            /**
             * Format: double
             * @description Part of the unknown ones whose decision was null.
             */
            unknown_refused: number;
            /**
             * @description Of the answers of about one confidence, how many were right. Each answer's confidence is of a curve fitted
             *     without it.
             */
            curve: components["schemas"]["ReliabilityBinBody"][];
            /**
             * Format: double
             * @description Below this confidence the decision is null.
             */
            threshold: number;
        };
        /** @description What a training told of itself, by the kind of its database. */
        ReportBody: components["schemas"]["LandmarkReportBody"] | components["schemas"]["ObjectsReportBody"];
        /** @description What is left of the planes' depths after the table. */
        ResidualBody: {
            /** Format: double */
            rms_mm: number;
            /** Format: double */
            max_mm: number;
        };
        /**
         * @description What becomes of a picture of another size: it is scaled to fit, centred on black, and the answer or report says
         *     so; or it is refused.
         * @enum {string}
         */
        ResizeWord: "fit" | "never";
        /**
         * @description What a key may do; each includes the ones before it.
         * @enum {string}
         */
        ScopeWord: "recognise" | "contribute" | "train" | "admin";
        /**
         * @description How the eigenpoints near a query are found; the answers are the same.
         * @enum {string}
         */
        SearchWord: "kd_tree" | "slabs" | "exhaustive";
        /** @description What stands out from the background. */
        SegmentationBody: {
            header: components["schemas"]["HeaderEcho"];
            width_px: number;
            height_px: number;
            /** @description Regions of at least the least area, also those beyond `max_objects`. */
            regions_found: number;
            /** @description The largest first. */
            regions: components["schemas"]["RegionBody"][];
            /** @description `no_region`: nothing stands out. `more_regions`: there are more than `max_objects`. */
            warnings: string[];
            timings_ms: components["schemas"]["SegmentationTimings"];
        };
        /** @description A picture, and how it is taken apart. */
        SegmentationForm: {
            /**
             * Format: binary
             * @description The picture.
             */
            image: Blob;
            options?: components["schemas"]["SegmentationOptionsBody"] | null;
        };
        /** @description Options of a segmentation. What is absent has its default. */
        SegmentationOptionsBody: {
            threshold?: components["schemas"]["ThresholdBody"] | null;
            /** @description Adaptive only: side of the square that the background is looked for in; null or absent: chosen from the picture. */
            window_px?: number | null;
            /**
             * Format: double
             * @description Adaptive only: how far a pixel must stand out from the background, in grey levels; null or absent: chosen from
             *     the picture.
             */
            offset?: number | null;
            polarity?: components["schemas"]["PolarityWord"] | null;
            /** @description Smaller regions are specks; null or absent: chosen from the picture. */
            min_area_px?: number | null;
            /**
             * @description Most regions that are told of, the largest.
             * @default 100
             */
            max_objects: number | null;
        };
        /** @description How long the parts of a segmentation took, in milliseconds. */
        SegmentationTimings: {
            /**
             * Format: double
             * @description Waiting for a computing thread.
             */
            queue: number;
            /** Format: double */
            decode: number;
            /** Format: double */
            segment: number;
        };
        /** @description The parts of what follows decoding, in milliseconds, by the kind of the database. */
        StagesBody: components["schemas"]["LandmarkStages"] | components["schemas"]["ObjectStages"];
        /**
         * @description Whether the universal eigenspace only proposes objects and each one's own settles which and how turned, or
         *     answers alone: for small sets.
         * @enum {string}
         */
        StagesWord: "universal_then_object" | "universal_only";
        /**
         * @description The life of a job.
         * @enum {string}
         */
        StateWord: "queued" | "running" | "succeeded" | "failed" | "cancelled";
        /**
         * @description A store as this process sees it.
         * @enum {string}
         */
        StoreStatus: "ok" | "unavailable";
        /** @description A form with a manifest, and one part for each picture that it names. */
        SweepForm: {
            /** @description JSON: planes at 5 known depths or more, better 9 to 21, that reach past both focus distances. */
            manifest: components["schemas"]["PlaneLine"][];
            options?: components["schemas"]["SweepOptionsBody"] | null;
        };
        /** @description How a sweep is to be measured. */
        SweepOptionsBody: {
            method?: components["schemas"]["DepthMethodWord"] | null;
            /**
             * @description Whether aperture, separation and near plane are fitted to the planes first.
             * @default false
             */
            fit_optics: boolean | null;
        };
        /** @description From what the method says to what is true, by planes at known depths. */
        TableBody: {
            /** @description Where the planes are between the focus distances: 1 near, −1 far. */
            beta: number[];
            /** @description What the method said. */
            raw: number[];
            /** @description Standard deviation of that over the plane. */
            sigma: number[];
            depth_mm: number[];
        };
        /**
         * @description How a sub-window fades towards its rim: over the radius alone, or over both axes as the paper's text has it.
         * @enum {string}
         */
        TaperWord: "radial" | "literal";
        /** @description A grey level, 0 to 255, or by itself. */
        ThresholdBody: number | components["schemas"]["ThresholdWord"];
        /**
         * @description `adaptive`: the mean of the background around each pixel, and an offset. `otsu`: one level for the picture, which
         *     tells two classes of pixels best apart.
         * @enum {string}
         */
        ThresholdWord: "adaptive" | "otsu";
        /** @description How long the parts of a recognition took, in milliseconds. */
        TimingsBody: components["schemas"]["LandmarkTimingsBody"] | components["schemas"]["ObjectTimingsBody"];
        /** @description A track. */
        TrackBody: {
            /** Format: uuid */
            id: string;
            database: string;
            /** @description The alias whose version answers. */
            alias: string;
            /** @description How robots are taken to move: `path` or `still`. */
            motion: components["schemas"]["MotionWord"];
            /**
             * Format: int64
             * @description The version that answered last.
             */
            version: number;
            /**
             * Format: int64
             * @description Frames that were counted.
             */
            frames: number;
            /**
             * @description `order_unknown`: `path` was asked for, but the version has exemplars that came with an artifact file or were
             *     deleted from the database, so that their order isn't known.
             */
            warnings: string[];
            /** Format: date-time */
            created_at: string;
            /**
             * Format: date-time
             * @description When it is gone unless another frame comes.
             */
            expires_at: string;
        };
        /** @description A track with what is believed. */
        TrackDetail: components["schemas"]["TrackBody"] & components["schemas"]["BeliefBody"];
        /**
         * @description What a frame shows, and where the robot is by all its frames so far. The fields are those of a recognition of this
         *     frame alone, but for `decision`, which is the track's.
         */
        TrackedFrameBody: components["schemas"]["LandmarkTrackedFrameBody"] | components["schemas"]["ObjectTrackedFrameBody"];
        /** @description How long the parts of a training took. */
        TrainingTimings: {
            /**
             * Format: double
             * @description Reading and describing the exemplars.
             */
            describe: number;
            /**
             * Format: double
             * @description Eigenspace, index and artifact.
             */
            eigenspace: number;
            /**
             * Format: double
             * @description Asking the new version about its exemplars seen otherwise; null where that isn't done.
             */
            rehearsal?: number | null;
        };
        /** @description A trained version. */
        VersionBody: {
            /** Format: int64 */
            version: number;
            /** @description Digest of the inputs: the same exemplars, options and algorithm give the same digest. */
            digest: string;
            /** Format: date-time */
            created_at: string;
            /**
             * Format: int64
             * @description Algorithm revision that trained it.
             */
            revision: number;
            /**
             * Format: int64
             * @description Size of the artifact file.
             */
            artifact_bytes: number;
            /**
             * @description What it was trained with. The colour of landmarks as it came out; the dimension and size of objects stand in the
             *     report.
             */
            options: components["schemas"]["OptionsBody"];
            counts: components["schemas"]["CountsBody"];
            report: components["schemas"]["ReportBody"];
        };
        /**
         * @description Whether the camera may turn about its axis, or stays upright as on wheels.
         * @enum {string}
         */
        ViewpointWord: "free" | "upright";
        /** @description The votes for a label. */
        VoteBody: {
            label: string;
            /**
             * Format: double
             * @description W of the label.
             */
            weight: number;
            /**
             * Format: double
             * @description Its part of all W.
             */
            share: number;
            /**
             * Format: int64
             * @description Votes that counted for it: of interest points, or with `placement` of their sub-windows.
             */
            points: number;
            placement?: components["schemas"]["PlacementBody"] | null;
        };
        /** @description The standard deviation of a Gaussian window in pixels, or `auto`: as large as the texture needs, pixel by pixel. */
        WindowBody: number | components["schemas"]["AutoWord"];
        /** @description A workcell as it is kept. */
        WorkcellBody: {
            name: string;
            database: string;
            calibration?: string | null;
            correspondences: components["schemas"]["CorrespondenceBody"][];
            flip_y: boolean;
            mapping: components["schemas"]["MappingBody"];
            local?: components["schemas"]["LocalCameraBody"] | null;
            /** Format: double */
            tolerance_px: number;
            /** @description All members; null: chosen from each picture. */
            segmentation: components["schemas"]["SegmentationOptionsBody"];
            /** @description `mirrored`: with the other `flip_y` the correspondences would fit far better, or two of them were exchanged. */
            warnings: string[];
            /** Format: date-time */
            created_at: string;
            /** Format: date-time */
            updated_at: string;
        };
        /** @description How long the parts of a recognition took, in milliseconds. */
        LandmarkTimingsBody: components["schemas"]["LandmarkStages"] & {
            /**
             * Format: double
             * @description Waiting for a computing thread.
             */
            queue: number;
            /** Format: double */
            decode: number;
            /**
             * Format: double
             * @description All that follows decoding.
             */
            recognise: number;
        };
        /** @description How long the parts of a recognition took, in milliseconds. */
        ObjectTimingsBody: components["schemas"]["ObjectStages"] & {
            /**
             * Format: double
             * @description Waiting for a computing thread.
             */
            queue: number;
            /** Format: double */
            decode: number;
            /**
             * Format: double
             * @description All that follows decoding.
             */
            recognise: number;
        };
        /** @description What a frame shows. */
        LandmarkRecognitionBody: components["schemas"]["LandmarkEvidence"] & {
            database: string;
            /** @enum {string} */
            kind: "landmarks";
            /**
             * Format: int64
             * @description The version that answered.
             */
            version: number;
            /** @description Its digest: the same frame and digest give the same answer. */
            digest: string;
            header: components["schemas"]["HeaderEcho"];
            decision?: components["schemas"]["DecisionBody"] | null;
            /**
             * @description Reasons to doubt the answer. Landmarks: `no_interest_points`, `too_few_points`, `votes_on_background`,
             *     `close_second`, `gray_frame`. Objects: `resized`, `blank_picture`, `over_exposed`, `beyond_threshold`,
             *     `close_second`, `not_calibrated`; with `segment` also `no_region`, `touches_border`, `several_regions`.
             */
            warnings: string[];
            timings_ms: components["schemas"]["LandmarkTimingsBody"];
        };
        /** @description What a frame shows. */
        ObjectRecognitionBody: components["schemas"]["ObjectEvidence"] & {
            database: string;
            /** @enum {string} */
            kind: "objects";
            /**
             * Format: int64
             * @description The version that answered.
             */
            version: number;
            /** @description Its digest: the same frame and digest give the same answer. */
            digest: string;
            header: components["schemas"]["HeaderEcho"];
            decision?: components["schemas"]["DecisionBody"] | null;
            /**
             * @description Reasons to doubt the answer. Landmarks: `no_interest_points`, `too_few_points`, `votes_on_background`,
             *     `close_second`, `gray_frame`. Objects: `resized`, `blank_picture`, `over_exposed`, `beyond_threshold`,
             *     `close_second`, `not_calibrated`; with `segment` also `no_region`, `touches_border`, `several_regions`.
             */
            warnings: string[];
            timings_ms: components["schemas"]["ObjectTimingsBody"];
        };
        /**
         * @description What a frame shows, and where the robot is by all its frames so far. The fields are those of a recognition of this
         *     frame alone, but for `decision`, which is the track's.
         */
        LandmarkTrackedFrameBody: components["schemas"]["LandmarkRecognitionBody"] & {
            /**
             * Format: uuid
             * @description Id of the track.
             */
            track: string;
            /** @description The likeliest labels, best first. */
            belief: components["schemas"]["LabelBeliefBody"][];
            /**
             * Format: double
             * @description Probability of being where no exemplar was taken.
             */
            elsewhere: number;
            /** @description What is this frame's alone. */
            frame: components["schemas"]["FrameBody"];
            /** @description How robots are taken to move: `path` or `still`. */
            motion: components["schemas"]["MotionWord"];
            /**
             * Format: date-time
             * @description When the track is gone unless another frame comes.
             */
            expires_at: string;
        };
        /**
         * @description What a frame shows, and where the robot is by all its frames so far. The fields are those of a recognition of this
         *     frame alone, but for `decision`, which is the track's.
         */
        ObjectTrackedFrameBody: components["schemas"]["ObjectRecognitionBody"] & {
            /**
             * Format: uuid
             * @description Id of the track.
             */
            track: string;
            /** @description The likeliest labels, best first. */
            belief: components["schemas"]["LabelBeliefBody"][];
            /**
             * Format: double
             * @description Probability of being where no exemplar was taken.
             */
            elsewhere: number;
            /** @description What is this frame's alone. */
            frame: components["schemas"]["FrameBody"];
            /** @description How robots are taken to move: `path` or `still`. */
            motion: components["schemas"]["MotionWord"];
            /**
             * Format: date-time
             * @description When the track is gone unless another frame comes.
             */
            expires_at: string;
        };
    };
    responses: never;
    parameters: never;
    requestBodies: never;
    headers: never;
    pathItems: never;
}
export type $defs = Record<string, never>;
export interface operations {
    livez: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Alive"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    metrics: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/plain; version=0.0.4": string;
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    readyz: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Ready"];
                };
            };
            /** @description Starting or shutting down */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Ready"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_audit: {
        parameters: {
            query?: {
                /** @description About this database. */
                database?: string;
                /** @description Done with the key of this id. */
                key?: string;
                /** @description Of this action, such as `alias.set`. */
                action?: string;
                /** @description Most items to give. */
                limit?: number;
                /** @description `next_cursor` of the page before. */
                cursor?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_AuditBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_calibrations: {
        parameters: {
            query?: {
                /** @description Most items to give. */
                limit?: number;
                /** @description `next_cursor` of the page before. */
                cursor?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_CalibrationBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_calibration: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the calibration. */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CalibrationBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    put_calibration: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the calibration. */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["OpticsBody"];
            };
        };
        responses: {
            /** @description It was there; with another optics, replaced */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CalibrationBody"];
                };
            };
            /** @description Created */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CalibrationBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_calibration: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the calibration. */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Gone */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    register_calibration: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the calibration. */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "multipart/form-data": components["schemas"]["RegistrationForm"];
            };
        };
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CalibrationBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    sweep_calibration: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the calibration. */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "multipart/form-data": components["schemas"]["SweepForm"];
            };
        };
        responses: {
            /** @description Queued */
            202: {
                headers: {
                    Location?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_databases: {
        parameters: {
            query?: {
                /** @description Most items to give. */
                limit?: number;
                /** @description `next_cursor` of the page before. */
                cursor?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_DatabaseBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_database: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["DatabaseDetail"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    put_database: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["NewDatabase"];
            };
        };
        responses: {
            /** @description It was there */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["DatabaseBody"];
                };
            };
            /** @description Created */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["DatabaseBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_database: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Gone */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_aliases: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_AliasBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_alias: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Name of the alias. */
                alias: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    ETag?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["AliasBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    put_alias: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Name of the alias. */
                alias: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["NewAlias"];
            };
        };
        responses: {
            /** @description Moved */
            200: {
                headers: {
                    ETag?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["AliasBody"];
                };
            };
            /** @description Created */
            201: {
                headers: {
                    ETag?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["AliasBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_alias: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Name of the alias. */
                alias: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Gone */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_exemplars: {
        parameters: {
            query?: {
                /** @description Those of this label. */
                label?: string;
                /** @description Those that this robot sent. */
                robot_id?: string;
                /** @description Those received at this moment or later, by the service's clock. */
                since?: string;
                /** @description Those received before this moment. */
                before?: string;
                /** @description Most items to give. */
                limit?: number;
                /** @description `next_cursor` of the page before. */
                cursor?: string;
            };
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_ExemplarBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    add_exemplar: {
        parameters: {
            query: {
                /** @description The place or object. */
                label: string;
                /** @description Turntable pose, in degrees. */
                pose_deg?: number;
            };
            header?: {
                /** @description Who sends it; comes back in `header`. */
                "X-Robot-Id"?: string;
                /** @description The robot's name for the frame; comes back in `header`. */
                "X-Frame-Id"?: string;
                /** @description When it was taken, RFC 3339 or `sec.nanosec`; comes back in `header`. */
                "X-Stamp"?: string;
            };
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        /** @description The picture, raw or as the part `image` of a form */
        requestBody: {
            content: {
                "application/octet-stream": Blob;
            };
        };
        responses: {
            /** @description It was there */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ExemplarBody"];
                };
            };
            /** @description Kept */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ExemplarBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_exemplars: {
        parameters: {
            query?: {
                /** @description Those of this label. */
                label?: string;
                /** @description Those that this robot sent. */
                robot_id?: string;
                /** @description Those received at this moment or later, by the service's clock. */
                since?: string;
                /** @description Those received before this moment. */
                before?: string;
            };
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Gone */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_exemplar: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Id of the exemplar. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ExemplarBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_exemplar: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Id of the exemplar. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Gone */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_exemplar_image: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Id of the exemplar. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The picture */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "image/jpeg": Blob;
                    "image/png": Blob;
                    "image/x-portable-anymap": Blob;
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    add_exemplar_batch: {
        parameters: {
            query?: never;
            header?: {
                /** @description Who sends it; comes back in `header`. */
                "X-Robot-Id"?: string;
                /** @description The robot's name for the frame; comes back in `header`. */
                "X-Frame-Id"?: string;
                /** @description When it was taken, RFC 3339 or `sec.nanosec`; comes back in `header`. */
                "X-Stamp"?: string;
            };
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/x-tar": Blob;
            };
        };
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["BatchBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    recognise: {
        parameters: {
            query?: {
                /** @description The alias whose version answers; `current` when neither alias nor version is given. */
                alias?: string;
                /** @description Number of the version that answers. */
                version?: number;
                /** @description Most labels in `votes` or `candidates`; of candidates there are five at most. */
                top?: number;
                /** @description Give every point's vote. Objects have no more to give. */
                explain?: boolean;
            };
            header?: {
                /** @description Who sends it; comes back in `header`. */
                "X-Robot-Id"?: string;
                /** @description The robot's name for the frame; comes back in `header`. */
                "X-Frame-Id"?: string;
                /** @description When it was taken, RFC 3339 or `sec.nanosec`; comes back in `header`. */
                "X-Stamp"?: string;
            };
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        /** @description The picture, raw or as the part `image` of a form */
        requestBody: {
            content: {
                "application/octet-stream": Blob;
            };
        };
        responses: {
            /** @description What the frame shows */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RecognitionBody"];
                    "image/png": Blob;
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    recognise_batch: {
        parameters: {
            query?: {
                /** @description The alias whose version answers; `current` when neither alias nor version is given. */
                alias?: string;
                /** @description Number of the version that answers. */
                version?: number;
                /** @description Most labels in `votes` or `candidates`; of candidates there are five at most. */
                top?: number;
                /** @description Give every point's vote. Objects have no more to give. */
                explain?: boolean;
            };
            header?: {
                /** @description Who sends it; comes back in `header`. */
                "X-Robot-Id"?: string;
                /** @description The robot's name for the frame; comes back in `header`. */
                "X-Frame-Id"?: string;
                /** @description When it was taken, RFC 3339 or `sec.nanosec`; comes back in `header`. */
                "X-Stamp"?: string;
            };
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "multipart/form-data": components["schemas"]["ImagesForm"];
            };
        };
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RecognitionBatch"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_tracks: {
        parameters: {
            query?: {
                /** @description Most items to give. */
                limit?: number;
                /** @description `next_cursor` of the page before. */
                cursor?: string;
            };
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_TrackBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    begin_track: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/json": components["schemas"]["NewTrack"] | null;
            };
        };
        responses: {
            /** @description Begun */
            201: {
                headers: {
                    Location?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["TrackBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_track: {
        parameters: {
            query?: {
                /** @description Most labels in `belief`. */
                top?: number;
            };
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Id of the track. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["TrackDetail"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    end_track: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Id of the track. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Gone */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    add_frame: {
        parameters: {
            query?: {
                /** @description Most labels in `belief` and in `votes`. */
                top?: number;
                /** @description Give every point's vote. */
                explain?: boolean;
            };
            header?: {
                /** @description Who sends it; comes back in `header`. */
                "X-Robot-Id"?: string;
                /** @description The robot's name for the frame; comes back in `header`. */
                "X-Frame-Id"?: string;
                /** @description When it was taken, RFC 3339 or `sec.nanosec`; comes back in `header`. */
                "X-Stamp"?: string;
            };
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Id of the track. */
                id: string;
            };
            cookie?: never;
        };
        /** @description The picture, raw or as the part `image` of a form */
        requestBody: {
            content: {
                "application/octet-stream": Blob;
            };
        };
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["TrackedFrameBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    begin_training: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/json": components["schemas"]["NewTraining"] | null;
            };
        };
        responses: {
            /** @description Queued */
            202: {
                headers: {
                    Location?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_versions: {
        parameters: {
            query?: {
                /** @description Most items to give. */
                limit?: number;
                /** @description `next_cursor` of the page before. */
                cursor?: string;
            };
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_VersionBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    import_version: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/octet-stream": Blob;
            };
        };
        responses: {
            /** @description It was there */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["VersionBody"];
                };
            };
            /** @description Taken in */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["VersionBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_version: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Number of the version. */
                version: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["VersionBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_version: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Number of the version. */
                version: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Gone */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_version_artifact: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Number of the version. */
                version: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The artifact file */
            200: {
                headers: {
                    ETag?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/octet-stream": Blob;
                };
            };
            /** @description You have it */
            304: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_eigenimage: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the database. */
                database: string;
                /** @description Number of the version. */
                version: number;
                /** @description `mean`, or the number of an eigenimage of the universal eigenspace, counted from 0. */
                image: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The picture */
            200: {
                headers: {
                    ETag?: string;
                    [name: string]: unknown;
                };
                content: {
                    "image/png": Blob;
                };
            };
            /** @description You have it */
            304: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    measure_depth: {
        parameters: {
            query?: {
                /**
                 * @description For `application/x-npy`: `depth` (mm, NaN = unknown), `sigma` (its expected standard deviation in mm), `flags`
                 *     (bits), with commas between them. One plane is an array H×W, several are n×H×W in the order given.
                 * @example depth,sigma,flags
                 */
                planes?: string;
            };
            header?: {
                /** @description Who sends it; comes back in `header`. */
                "X-Robot-Id"?: string;
                /** @description The robot's name for the frame; comes back in `header`. */
                "X-Frame-Id"?: string;
                /** @description When it was taken, RFC 3339 or `sec.nanosec`; comes back in `header`. */
                "X-Stamp"?: string;
            };
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "multipart/form-data": components["schemas"]["DepthForm"];
            };
        };
        responses: {
            /** @description The depth map */
            200: {
                headers: {
                    /** @description Files: as `coverage` */
                    "X-Coverage"?: number;
                    /** @description 16-bit PNG: mm a grey level */
                    "X-Depth-Scale-Mm"?: number;
                    /** @description Files: as `far_focus_mm` */
                    "X-Far-Focus-Mm"?: number;
                    /** @description Files: as `near_focus_mm` */
                    "X-Near-Focus-Mm"?: number;
                    /** @description Files: as `warnings`, with commas between */
                    "X-Warnings"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["DepthMapBody"];
                    "image/png": Blob;
                    "application/x-npy": Blob;
                    "model/ply": Blob;
                    "image/png; preview=turbo": Blob;
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    info: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Info"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_jobs: {
        parameters: {
            query?: {
                /** @description Those of this database. */
                database?: string;
                /** @description Those of this calibration. */
                calibration?: string;
                /** @description Those in this state. */
                state?: "queued" | "running" | "succeeded" | "failed" | "cancelled";
                /** @description Most items to give. */
                limit?: number;
                /** @description `next_cursor` of the page before. */
                cursor?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_JobBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_job: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the job. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    cancel_job: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the job. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description It will end */
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["JobBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    follow_job: {
        parameters: {
            query?: never;
            header?: {
                /** @description Number of the last event seen. */
                "Last-Event-ID"?: number;
            };
            path: {
                /** @description Id of the job. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Events whose data is a job */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/event-stream": components["schemas"]["JobEvent"];
                };
            };
            /** @description The job has ended and you have seen its last event */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_keys: {
        parameters: {
            query?: {
                /** @description Most items to give. */
                limit?: number;
                /** @description `next_cursor` of the page before. */
                cursor?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_KeyBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    create_key: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["NewKeyBody"];
            };
        };
        responses: {
            /** @description The answer */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["KeyMade"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_key: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the key. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["KeyBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    revoke_key: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the key. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description It isn't taken any more */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    segment: {
        parameters: {
            query?: {
                /** @description What a pixel is held against: `adaptive` (the default), `otsu`, or a grey level. */
                threshold?: components["schemas"]["ThresholdBody"];
                /** @description Adaptive only: side of the square that the background is looked for in; null or absent: chosen from the picture. */
                window_px?: number;
                /**
                 * @description Adaptive only: how far a pixel must stand out from the background, in grey levels; null or absent: chosen from
                 *     the picture.
                 */
                offset?: number;
                /** @description Whether objects are lighter than the background (the default) or darker. */
                polarity?: components["schemas"]["PolarityWord"];
                /** @description Smaller regions are specks; null or absent: chosen from the picture. */
                min_area_px?: number;
                /** @description Most regions that are told of, the largest. */
                max_objects?: number;
            };
            header?: {
                /** @description Who sends it; comes back in `header`. */
                "X-Robot-Id"?: string;
                /** @description The robot's name for the frame; comes back in `header`. */
                "X-Frame-Id"?: string;
                /** @description When it was taken, RFC 3339 or `sec.nanosec`; comes back in `header`. */
                "X-Stamp"?: string;
            };
            path?: never;
            cookie?: never;
        };
        /** @description The picture, raw with the options in the query, or as a form */
        requestBody: {
            content: {
                "application/octet-stream": Blob;
            };
        };
        responses: {
            /** @description What stands out */
            200: {
                headers: {
                    /** @description Pictures: as `warnings`, with commas between */
                    "X-Warnings"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SegmentationBody"];
                    "image/png": Blob;
                    "image/png; preview=regions": Blob;
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_workcells: {
        parameters: {
            query?: {
                /** @description Most items to give. */
                limit?: number;
                /** @description `next_cursor` of the page before. */
                cursor?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Page_WorkcellBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_workcell: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the workcell. */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["WorkcellBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    put_workcell: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the workcell. */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["PutWorkcell"];
            };
        };
        responses: {
            /** @description It was there, and is replaced */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["WorkcellBody"];
                };
            };
            /** @description Created */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["WorkcellBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_workcell: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Name of the workcell. */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Gone */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    centre: {
        parameters: {
            query?: never;
            header?: {
                /** @description Who sends it; comes back in `header`. */
                "X-Robot-Id"?: string;
                /** @description The robot's name for the frame; comes back in `header`. */
                "X-Frame-Id"?: string;
                /** @description When it was taken, RFC 3339 or `sec.nanosec`; comes back in `header`. */
                "X-Stamp"?: string;
            };
            path: {
                /** @description Name of the workcell. */
                name: string;
            };
            cookie?: never;
        };
        /** @description The picture, raw or as the part `image` of a form */
        requestBody: {
            content: {
                "application/octet-stream": Blob;
            };
        };
        responses: {
            /** @description The answer */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CentringBody"];
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    inspect: {
        parameters: {
            query?: {
                /** @description The alias whose version answers; `current` when neither alias nor version is given. */
                alias?: string;
                /** @description Number of the version that answers. */
                version?: number;
                /**
                 * @description With a pair of one part: the id of its region; by default the only one, or the one nearest the overview's
                 *     middle.
                 */
                region?: number;
                /**
                 * @description With a pair: `local` (one part, seen by the local camera) or `overview` (the overview's geometry: every part
                 *     gets its distance).
                 */
                pair_view?: "local" | "overview";
            };
            header?: {
                /** @description Who sends it; comes back in `header`. */
                "X-Robot-Id"?: string;
                /** @description The robot's name for the frame; comes back in `header`. */
                "X-Frame-Id"?: string;
                /** @description When it was taken, RFC 3339 or `sec.nanosec`; comes back in `header`. */
                "X-Stamp"?: string;
            };
            path: {
                /** @description Name of the workcell. */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "multipart/form-data": components["schemas"]["InspectionForm"];
            };
        };
        responses: {
            /** @description What stands on the table */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["InspectionBody"];
                    "image/png": Blob;
                };
            };
            /** @description A problem document: what went wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
}
