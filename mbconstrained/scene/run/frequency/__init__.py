"""The frequency response of a scene: computed (``scene_frequency``), printed (``frequency_summary``), on its page (``response_page``)."""
