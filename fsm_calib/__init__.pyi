from fsm_calib.api import calibrate_camera as calibrate_camera
from fsm_calib.api import diagnose as diagnose
from fsm_calib.api import identify as identify
from fsm_calib.api import investigate as investigate
from fsm_calib.api import load_world as load_world
from fsm_calib.api import read_recording as read_recording
from fsm_calib.api import run as run

__version__: str
__all__: list[str]
