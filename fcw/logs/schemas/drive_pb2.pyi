from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Box(_message.Message):
    __slots__ = ("x", "y", "w", "h")
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    W_FIELD_NUMBER: _ClassVar[int]
    H_FIELD_NUMBER: _ClassVar[int]
    x: float
    y: float
    w: float
    h: float
    def __init__(self, x: _Optional[float] = ..., y: _Optional[float] = ..., w: _Optional[float] = ..., h: _Optional[float] = ...) -> None: ...

class Detection(_message.Message):
    __slots__ = ("box", "score")
    BOX_FIELD_NUMBER: _ClassVar[int]
    SCORE_FIELD_NUMBER: _ClassVar[int]
    box: Box
    score: float
    def __init__(self, box: _Optional[_Union[Box, _Mapping]] = ..., score: _Optional[float] = ...) -> None: ...

class Track(_message.Message):
    __slots__ = ("track_id", "box", "score", "distance_m", "distance_low_m", "distance_high_m", "lateral_m", "closing_speed_mps", "closing_speed_sigma_mps", "ttc_s", "age_s", "coasting", "in_path", "closing_acceleration_mps2", "closing_acceleration_sigma_mps2", "lateral_speed_mps", "seen_by", "width_m", "lateral_sigma_m", "lateral_speed_sigma_mps", "doubtful", "closing_speed_sigma_at_distance_mps", "found_part", "lateral_slowing_mps2", "lateral_speed_by_bearing_mps", "lateral_speed_by_bearing_sigma_mps")
    class SeenBy(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        UNSAID: _ClassVar[Track.SeenBy]
        DETECTOR: _ClassVar[Track.SeenBy]
        PICTURE: _ClassVar[Track.SeenBy]
        COASTING: _ClassVar[Track.SeenBy]
    UNSAID: Track.SeenBy
    DETECTOR: Track.SeenBy
    PICTURE: Track.SeenBy
    COASTING: Track.SeenBy
    TRACK_ID_FIELD_NUMBER: _ClassVar[int]
    BOX_FIELD_NUMBER: _ClassVar[int]
    SCORE_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_M_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_LOW_M_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_HIGH_M_FIELD_NUMBER: _ClassVar[int]
    LATERAL_M_FIELD_NUMBER: _ClassVar[int]
    CLOSING_SPEED_MPS_FIELD_NUMBER: _ClassVar[int]
    CLOSING_SPEED_SIGMA_MPS_FIELD_NUMBER: _ClassVar[int]
    TTC_S_FIELD_NUMBER: _ClassVar[int]
    AGE_S_FIELD_NUMBER: _ClassVar[int]
    COASTING_FIELD_NUMBER: _ClassVar[int]
    IN_PATH_FIELD_NUMBER: _ClassVar[int]
    CLOSING_ACCELERATION_MPS2_FIELD_NUMBER: _ClassVar[int]
    CLOSING_ACCELERATION_SIGMA_MPS2_FIELD_NUMBER: _ClassVar[int]
    LATERAL_SPEED_MPS_FIELD_NUMBER: _ClassVar[int]
    SEEN_BY_FIELD_NUMBER: _ClassVar[int]
    WIDTH_M_FIELD_NUMBER: _ClassVar[int]
    LATERAL_SIGMA_M_FIELD_NUMBER: _ClassVar[int]
    LATERAL_SPEED_SIGMA_MPS_FIELD_NUMBER: _ClassVar[int]
    DOUBTFUL_FIELD_NUMBER: _ClassVar[int]
    CLOSING_SPEED_SIGMA_AT_DISTANCE_MPS_FIELD_NUMBER: _ClassVar[int]
    FOUND_PART_FIELD_NUMBER: _ClassVar[int]
    LATERAL_SLOWING_MPS2_FIELD_NUMBER: _ClassVar[int]
    LATERAL_SPEED_BY_BEARING_MPS_FIELD_NUMBER: _ClassVar[int]
    LATERAL_SPEED_BY_BEARING_SIGMA_MPS_FIELD_NUMBER: _ClassVar[int]
    track_id: int
    box: Box
    score: float
    distance_m: float
    distance_low_m: float
    distance_high_m: float
    lateral_m: float
    closing_speed_mps: float
    closing_speed_sigma_mps: float
    ttc_s: float
    age_s: float
    coasting: bool
    in_path: bool
    closing_acceleration_mps2: float
    closing_acceleration_sigma_mps2: float
    lateral_speed_mps: float
    seen_by: Track.SeenBy
    width_m: float
    lateral_sigma_m: float
    lateral_speed_sigma_mps: float
    doubtful: bool
    closing_speed_sigma_at_distance_mps: float
    found_part: float
    lateral_slowing_mps2: float
    lateral_speed_by_bearing_mps: float
    lateral_speed_by_bearing_sigma_mps: float
    def __init__(self, track_id: _Optional[int] = ..., box: _Optional[_Union[Box, _Mapping]] = ..., score: _Optional[float] = ..., distance_m: _Optional[float] = ..., distance_low_m: _Optional[float] = ..., distance_high_m: _Optional[float] = ..., lateral_m: _Optional[float] = ..., closing_speed_mps: _Optional[float] = ..., closing_speed_sigma_mps: _Optional[float] = ..., ttc_s: _Optional[float] = ..., age_s: _Optional[float] = ..., coasting: bool = ..., in_path: bool = ..., closing_acceleration_mps2: _Optional[float] = ..., closing_acceleration_sigma_mps2: _Optional[float] = ..., lateral_speed_mps: _Optional[float] = ..., seen_by: _Optional[_Union[Track.SeenBy, str]] = ..., width_m: _Optional[float] = ..., lateral_sigma_m: _Optional[float] = ..., lateral_speed_sigma_mps: _Optional[float] = ..., doubtful: bool = ..., closing_speed_sigma_at_distance_mps: _Optional[float] = ..., found_part: _Optional[float] = ..., lateral_slowing_mps2: _Optional[float] = ..., lateral_speed_by_bearing_mps: _Optional[float] = ..., lateral_speed_by_bearing_sigma_mps: _Optional[float] = ...) -> None: ...

class WarningState(_message.Message):
    __slots__ = ("level", "track_id", "rule", "ttc_s", "required_deceleration_mps2", "headway_s", "distance_m", "distance_low_m", "distance_high_m", "closing_speed_mps", "overlap_m", "collision_probability", "needed_distance_m", "assumes", "extrapolated")
    class Level(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        NONE: _ClassVar[WarningState.Level]
        ADVISORY: _ClassVar[WarningState.Level]
        CAUTION: _ClassVar[WarningState.Level]
        WARNING: _ClassVar[WarningState.Level]
    NONE: WarningState.Level
    ADVISORY: WarningState.Level
    CAUTION: WarningState.Level
    WARNING: WarningState.Level
    LEVEL_FIELD_NUMBER: _ClassVar[int]
    TRACK_ID_FIELD_NUMBER: _ClassVar[int]
    RULE_FIELD_NUMBER: _ClassVar[int]
    TTC_S_FIELD_NUMBER: _ClassVar[int]
    REQUIRED_DECELERATION_MPS2_FIELD_NUMBER: _ClassVar[int]
    HEADWAY_S_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_M_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_LOW_M_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_HIGH_M_FIELD_NUMBER: _ClassVar[int]
    CLOSING_SPEED_MPS_FIELD_NUMBER: _ClassVar[int]
    OVERLAP_M_FIELD_NUMBER: _ClassVar[int]
    COLLISION_PROBABILITY_FIELD_NUMBER: _ClassVar[int]
    NEEDED_DISTANCE_M_FIELD_NUMBER: _ClassVar[int]
    ASSUMES_FIELD_NUMBER: _ClassVar[int]
    EXTRAPOLATED_FIELD_NUMBER: _ClassVar[int]
    level: WarningState.Level
    track_id: int
    rule: str
    ttc_s: float
    required_deceleration_mps2: float
    headway_s: float
    distance_m: float
    distance_low_m: float
    distance_high_m: float
    closing_speed_mps: float
    overlap_m: float
    collision_probability: float
    needed_distance_m: float
    assumes: str
    extrapolated: bool
    def __init__(self, level: _Optional[_Union[WarningState.Level, str]] = ..., track_id: _Optional[int] = ..., rule: _Optional[str] = ..., ttc_s: _Optional[float] = ..., required_deceleration_mps2: _Optional[float] = ..., headway_s: _Optional[float] = ..., distance_m: _Optional[float] = ..., distance_low_m: _Optional[float] = ..., distance_high_m: _Optional[float] = ..., closing_speed_mps: _Optional[float] = ..., overlap_m: _Optional[float] = ..., collision_probability: _Optional[float] = ..., needed_distance_m: _Optional[float] = ..., assumes: _Optional[str] = ..., extrapolated: bool = ...) -> None: ...

class Mount(_message.Message):
    __slots__ = ("pitch_rad", "yaw_rad", "roll_rad", "pitch_sigma_rad", "yaw_sigma_rad", "roll_sigma_rad")
    PITCH_RAD_FIELD_NUMBER: _ClassVar[int]
    YAW_RAD_FIELD_NUMBER: _ClassVar[int]
    ROLL_RAD_FIELD_NUMBER: _ClassVar[int]
    PITCH_SIGMA_RAD_FIELD_NUMBER: _ClassVar[int]
    YAW_SIGMA_RAD_FIELD_NUMBER: _ClassVar[int]
    ROLL_SIGMA_RAD_FIELD_NUMBER: _ClassVar[int]
    pitch_rad: float
    yaw_rad: float
    roll_rad: float
    pitch_sigma_rad: float
    yaw_sigma_rad: float
    roll_sigma_rad: float
    def __init__(self, pitch_rad: _Optional[float] = ..., yaw_rad: _Optional[float] = ..., roll_rad: _Optional[float] = ..., pitch_sigma_rad: _Optional[float] = ..., yaw_sigma_rad: _Optional[float] = ..., roll_sigma_rad: _Optional[float] = ...) -> None: ...

class OwnMotion(_message.Message):
    __slots__ = ("speed_mps", "speed_sigma_mps", "speed_source", "yaw_rate_radps", "yaw_rate_sigma_radps", "mount", "picture_speed_mps")
    class SpeedSource(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        UNKNOWN: _ClassVar[OwnMotion.SpeedSource]
        GIVEN: _ClassVar[OwnMotion.SpeedSource]
        PICTURE: _ClassVar[OwnMotion.SpeedSource]
    UNKNOWN: OwnMotion.SpeedSource
    GIVEN: OwnMotion.SpeedSource
    PICTURE: OwnMotion.SpeedSource
    SPEED_MPS_FIELD_NUMBER: _ClassVar[int]
    SPEED_SIGMA_MPS_FIELD_NUMBER: _ClassVar[int]
    SPEED_SOURCE_FIELD_NUMBER: _ClassVar[int]
    YAW_RATE_RADPS_FIELD_NUMBER: _ClassVar[int]
    YAW_RATE_SIGMA_RADPS_FIELD_NUMBER: _ClassVar[int]
    MOUNT_FIELD_NUMBER: _ClassVar[int]
    PICTURE_SPEED_MPS_FIELD_NUMBER: _ClassVar[int]
    speed_mps: float
    speed_sigma_mps: float
    speed_source: OwnMotion.SpeedSource
    yaw_rate_radps: float
    yaw_rate_sigma_radps: float
    mount: Mount
    picture_speed_mps: float
    def __init__(self, speed_mps: _Optional[float] = ..., speed_sigma_mps: _Optional[float] = ..., speed_source: _Optional[_Union[OwnMotion.SpeedSource, str]] = ..., yaw_rate_radps: _Optional[float] = ..., yaw_rate_sigma_radps: _Optional[float] = ..., mount: _Optional[_Union[Mount, _Mapping]] = ..., picture_speed_mps: _Optional[float] = ...) -> None: ...

class OwnPath(_message.Message):
    __slots__ = ("offset_m", "heading_rad", "curvature_per_m", "offset_sigma_m", "heading_sigma_rad", "curvature_sigma_per_m", "lane_width_m", "growth_per_m2")
    OFFSET_M_FIELD_NUMBER: _ClassVar[int]
    HEADING_RAD_FIELD_NUMBER: _ClassVar[int]
    CURVATURE_PER_M_FIELD_NUMBER: _ClassVar[int]
    OFFSET_SIGMA_M_FIELD_NUMBER: _ClassVar[int]
    HEADING_SIGMA_RAD_FIELD_NUMBER: _ClassVar[int]
    CURVATURE_SIGMA_PER_M_FIELD_NUMBER: _ClassVar[int]
    LANE_WIDTH_M_FIELD_NUMBER: _ClassVar[int]
    GROWTH_PER_M2_FIELD_NUMBER: _ClassVar[int]
    offset_m: float
    heading_rad: float
    curvature_per_m: float
    offset_sigma_m: float
    heading_sigma_rad: float
    curvature_sigma_per_m: float
    lane_width_m: float
    growth_per_m2: float
    def __init__(self, offset_m: _Optional[float] = ..., heading_rad: _Optional[float] = ..., curvature_per_m: _Optional[float] = ..., offset_sigma_m: _Optional[float] = ..., heading_sigma_rad: _Optional[float] = ..., curvature_sigma_per_m: _Optional[float] = ..., lane_width_m: _Optional[float] = ..., growth_per_m2: _Optional[float] = ...) -> None: ...

class FrameResult(_message.Message):
    __slots__ = ("index", "time_ns", "detections", "tracks", "lead_id", "warning", "ego_speed_mps", "notes", "own_motion", "own_path", "unsearched", "repeated_picture")
    INDEX_FIELD_NUMBER: _ClassVar[int]
    TIME_NS_FIELD_NUMBER: _ClassVar[int]
    DETECTIONS_FIELD_NUMBER: _ClassVar[int]
    TRACKS_FIELD_NUMBER: _ClassVar[int]
    LEAD_ID_FIELD_NUMBER: _ClassVar[int]
    WARNING_FIELD_NUMBER: _ClassVar[int]
    EGO_SPEED_MPS_FIELD_NUMBER: _ClassVar[int]
    NOTES_FIELD_NUMBER: _ClassVar[int]
    OWN_MOTION_FIELD_NUMBER: _ClassVar[int]
    OWN_PATH_FIELD_NUMBER: _ClassVar[int]
    UNSEARCHED_FIELD_NUMBER: _ClassVar[int]
    REPEATED_PICTURE_FIELD_NUMBER: _ClassVar[int]
    index: int
    time_ns: int
    detections: _containers.RepeatedCompositeFieldContainer[Detection]
    tracks: _containers.RepeatedCompositeFieldContainer[Track]
    lead_id: int
    warning: WarningState
    ego_speed_mps: float
    notes: _containers.RepeatedScalarFieldContainer[str]
    own_motion: OwnMotion
    own_path: OwnPath
    unsearched: bool
    repeated_picture: bool
    def __init__(self, index: _Optional[int] = ..., time_ns: _Optional[int] = ..., detections: _Optional[_Iterable[_Union[Detection, _Mapping]]] = ..., tracks: _Optional[_Iterable[_Union[Track, _Mapping]]] = ..., lead_id: _Optional[int] = ..., warning: _Optional[_Union[WarningState, _Mapping]] = ..., ego_speed_mps: _Optional[float] = ..., notes: _Optional[_Iterable[str]] = ..., own_motion: _Optional[_Union[OwnMotion, _Mapping]] = ..., own_path: _Optional[_Union[OwnPath, _Mapping]] = ..., unsearched: bool = ..., repeated_picture: bool = ...) -> None: ...

class VideoPacket(_message.Message):
    __slots__ = ("time_ns", "keyframe", "shown", "frame_index")
    TIME_NS_FIELD_NUMBER: _ClassVar[int]
    KEYFRAME_FIELD_NUMBER: _ClassVar[int]
    SHOWN_FIELD_NUMBER: _ClassVar[int]
    FRAME_INDEX_FIELD_NUMBER: _ClassVar[int]
    time_ns: int
    keyframe: bool
    shown: bool
    frame_index: int
    def __init__(self, time_ns: _Optional[int] = ..., keyframe: bool = ..., shown: bool = ..., frame_index: _Optional[int] = ...) -> None: ...
